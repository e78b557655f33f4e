/* clustermcml furnace: flies a scene in diffuse light from above and below, without absorption. Radiance over
 * the square of the index is then the same everywhere, whatever the shapes, so the light in each turbid
 * medium follows from its volume alone:
 *
 *      | | | | |  lambertian, share n_above^2
 *      v v v v v
 *     ~~~~~~~~~~~~
 *       layer  (O)  body        absorbed share = mua V 4 n^2 / (area (n_above^2 + n_below^2))
 *     ~~~~~~~~~~~~
 *      ^ ^ ^ ^ ^
 *      | | | | |  lambertian, share n_below^2
 *
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "base/constants.h"
#include "base/json_name.h"
#include "base/significance.h"
#include "base/version.h"
#include "run/cluster/cluster.h"
#include "scene/body/body_shape.h"
#include "simulation/simulation.h"
#include "surface/mean_depth.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* mua / mus of the scene that is flown: a trace of absorption that counts interactions. A packet with k
 * interactions ends with the weight 1 - k 1e-10; the rounding of such small absorption makes the mean wrong
 * by 4e-5 of itself (cml_absorbed_part). */
#define TRACER 1e-10
/* largest optical depth of a layer; packets would hardly ever leave thicker ones */
#define MOST_DEPTH 1e4
#define MOST_PERIODS 10000
#define ROWS 40 /* places printed at most */

/* A place where light is tested: a layer, a body, or the space below. */
struct place {
    char name[48];
    const char *untested; /* reason why the place is not tested; NULL: it is */
    double volume;        /* cm3; NAN: parts overlap, and the volume is unknown */
    double ratio, error;  /* light found / light expected, and its standard error */
    double z;             /* difference of the ratio from 1, as a normal deviate */
};

struct furnace {
    /* The scene that is flown. Media, beams and shares are its own; the rest is borrowed. */
    struct cml_scene scene;
    struct cml_beam beams[2];
    double shares[2];
    double size[2], area; /* size of both beams along x and y, cm; their area, cm2 */
    int num_places, tested, worst;
    struct place *place; /* [num_places]: below, layers, bodies */
    double p;
};

/* ---- the scene ---- */

static double larger_of(double a, double b)
{
    return a > b ? a : b;
}

/* Sets how far a boundary reaches from the z axis (*aside) and from its nominal depth (*up), cm. */
static void reach_of(const struct cml_boundary *boundary, double *aside, double *up)
{
    const struct cml_radial *radial = &boundary->radial;
    const struct cml_heightmap *tile = &boundary->tile;
    const struct cml_mesh *mesh = &boundary->mesh;
    *aside = *up = 0;
    if (boundary->form == CML_FORM_RADIAL) *aside = radial->r[radial->n - 1];
    for (int i = 0; boundary->form == CML_FORM_RADIAL && i < radial->n; i++)
        *up = larger_of(*up, fabs(radial->h[i]));
    for (size_t i = 0; boundary->form == CML_FORM_TILE && i < (size_t)tile->nx * (size_t)tile->ny; i++)
        *up = larger_of(*up, fabs(tile->h[i]));
    if (boundary->form != CML_FORM_MESH) return;
    for (int k = 0; k < 2; k++) *aside = larger_of(*aside, larger_of(-mesh->lower[k], mesh->upper[k]));
    *up = larger_of(-mesh->lower[2], mesh->upper[2]);
}

/* True if a ratio is a whole number, but for rounding. */
static bool is_whole(double ratio)
{
    return fabs(ratio - round(ratio)) < 1e-9 * ratio;
}

/* Sets *size to the shortest length from `least` on that is a whole number of periods of all tiles; to
 * `least` if there are no tiles. */
static cml_status fit_periods(const struct cml_scene *scene, int axis, double least, double *size,
                              struct cml_error *err)
{
    double first = 0;
    for (int b = 0; b <= scene->num_layers && first == 0; b++)
        if (scene->boundaries[b].form == CML_FORM_TILE)
            first = cml_tile_period(&scene->boundaries[b].tile, axis);
    *size = least;
    if (first == 0) return CML_OK;
    for (double periods = larger_of(1, ceil(least / first)); periods <= MOST_PERIODS; periods++) {
        bool fits = true;
        *size = periods * first;
        for (int b = 0; b <= scene->num_layers && fits; b++)
            fits = scene->boundaries[b].form != CML_FORM_TILE ||
                   is_whole(*size / cml_tile_period(&scene->boundaries[b].tile, axis));
        if (fits) return CML_OK;
    }
    return cml_fail(
        err, CML_E_INPUT,
        "%s: the tiles have no common period along %s (expected one of at most %d periods of the first tile)",
        scene->output, axis ? "y" : "x", MOST_PERIODS);
}

/* Chooses the area of the beams: whole periods of tiles; else an area around all shapes that is so large that
 * light from beyond it would change little. *lift: height of the last boundary above its nominal depth, cm.
 */
static cml_status choose_area(const struct cml_scene *scene, struct furnace *f, double *lift,
                              struct cml_error *err)
{
    double widest = 0, relief = 0, thickness = 0;
    for (int b = 0; b <= scene->num_layers; b++) {
        double aside, up;
        reach_of(&scene->boundaries[b], &aside, &up);
        widest = larger_of(widest, aside);
        relief = larger_of(relief, up);
        thickness += scene->media[b].d;
        if (b == scene->num_layers) *lift = up;
    }
    for (int k = 0; k < scene->num_bodies; k++) {
        double lower[3], upper[3];
        cml_body_box(&scene->bodies[k], lower, upper);
        for (int axis = 0; axis < 2; axis++) widest = larger_of(widest, larger_of(-lower[axis], upper[axis]));
    }
    const double least = 2 * (widest + (widest > 0 ? 4 * (thickness + relief) : 0));
    for (int axis = 0; axis < 2; axis++)
        CML_TRY(fit_periods(scene, axis, least > 0 ? least : 1, &f->size[axis], err));
    f->area = f->size[0] * f->size[1];
    return CML_OK;
}

/* Returns a beam of diffuse (Lambertian) light over the whole area of the furnace. */
static struct cml_beam diffuse_beam(const struct furnace *f)
{
    return (struct cml_beam){.shape = CML_BEAM_RECTANGLE,
                             .size = {f->size[0], f->size[1]},
                             .light = {.kind = CML_LIGHT_OF_LAMBERTIAN}};
}

/* Refuses a backing, faces and ports, and layers in which light would stay for ever. */
static cml_status check_media(const struct cml_scene *scene, struct cml_error *err)
{
    if (scene->backing.kind != CML_BACKING_NONE)
        return cml_fail(err, CML_E_INPUT,
                        "%s:%d: a backing (expected none in a furnace: light comes from there)", scene->file,
                        scene->backing.line);
    if (scene->num_contacts > 0)
        return cml_fail(
            err, CML_E_INPUT,
            "%s:%d: boundary 0 has a face (expected no face or port line in a furnace: light comes "
            "from there)",
            scene->file, scene->contacts->line);
    for (int l = 1; l <= scene->num_layers; l++)
        if (scene->media[l].mus * scene->media[l].d > MOST_DEPTH)
            return cml_fail(
                err, CML_E_INPUT,
                "%s: layer %d: mus d = %g (expected at most %g in a furnace: light would stay for ever)",
                scene->output, l, scene->media[l].mus * scene->media[l].d, MOST_DEPTH);
    return CML_OK;
}

/* Makes the scene that a furnace flies: the same media with a trace of absorption, by which interactions are
 * counted, and two diffuse beams from above and below. Their shares are the squares of the indices
 * outside. */
static cml_status light_scene(const struct cml_scene *scene, struct furnace *f, struct cml_error *err)
{
    const size_t media = (size_t)scene->num_layers + 2 + (size_t)scene->num_bodies;
    const struct cml_medium_def *above = &scene->media[0], *below = &scene->media[scene->num_layers + 1];
    double lift = 0;
    CML_TRY(check_media(scene, err));
    CML_TRY(choose_area(scene, f, &lift, err));
    struct cml_medium_def *own;
    CML_TRY(cml_zeros(&own, media, sizeof *own, "media", err));
    memcpy(own, scene->media, media * sizeof *own);
    for (size_t m = 0; m < media; m++) own[m].mua = TRACER * own[m].mus;
    f->scene = *scene;
    cml_scene_ask_nothing(&f->scene);
    f->scene.nr = f->scene.nz = f->scene.na = 1;
    f->scene.media = own;
    f->scene.beams = f->beams;
    f->scene.shares = f->shares;
    f->scene.num_beams = 2;
    f->beams[0] = f->beams[1] = diffuse_beam(f);
    f->beams[1].inside = true;
    f->beams[1].z = scene->boundaries[scene->num_layers].z + lift + 1e-3 * f->size[0];
    f->beams[1].angle = CML_PI;
    f->shares[0] = above->n * above->n;
    f->shares[1] = below->n * below->n;
    return CML_OK;
}

/* ---- the light expected ---- */

/* Finds the volume of each layer, without its bodies, and of each body, without the bodies inside. */
static cml_status find_volumes(struct furnace *f, const struct cml_surface_set *surfaces,
                               const struct cml_surface_options *options, struct cml_error *err)
{
    const struct cml_scene *scene = &f->scene;
    double upper = 0, lower = 0;
    for (int b = 0; b <= scene->num_layers; b++) {
        CML_TRY(cml_mean_depth(scene, surfaces, b, options, f->area, &lower, err));
        if (b > 0) f->place[b].volume = (lower - upper) * f->area;
        upper = lower;
    }
    for (int k = 0; k < scene->num_bodies; k++) {
        const struct cml_scene_body *body = &scene->bodies[k];
        const int host = body->host > scene->num_layers ? body->host - 1 : body->host;
        const double volume = body->mesh.unite ? NAN : cml_body_volume(body);
        f->place[scene->num_layers + 1 + k].volume += volume;
        f->place[host].volume -= volume;
    }
    return CML_OK;
}

/* Compares the light found in a place, with its standard error from 64 batches, with the law of even light:
 * sets ratio, error and z. */
static void judge(struct furnace *f, int i, double share, double error, double law)
{
    struct place *place = &f->place[i];
    place->ratio = share / law;
    place->error = error / law;
    if (!place->untested && !(error > 0)) place->untested = "no light came there";
    if (place->untested) return;
    place->z = cml_normal_of_student((share - law) / error, CML_NUM_BATCHES - 1);
    if (f->tested++ == 0 || fabs(place->z) > fabs(f->place[f->worst].z)) f->worst = i;
}

/* Judges a medium. Its fluence is 4 n^2 times the irradiance in vacuum, so its absorbed share is mua times
 * volume times fluence, over the light sent in. */
static void judge_medium(struct furnace *f, const struct cml_result *result, int i)
{
    const struct cml_scene *scene = &f->scene;
    const int m = i > scene->num_layers ? i + 1 : i, media = (int)cml_tally_media(&result->grid);
    const struct cml_medium_def *medium = &scene->media[m];
    struct place *place = &f->place[i];
    const double law =
        4 * medium->n * medium->n * medium->mua * place->volume / (f->area * (f->shares[0] + f->shares[1]));
    place->untested = !(medium->mus > 0)     ? "clear"
                      : isnan(place->volume) ? "parts that overlap"
                      : !(place->volume > 0) ? "no volume"
                                             : NULL;
    judge(f, i, cml_result_bin_sum(result->A_l, media, m) * CML_WEIGHT_UNIT / (double)result->photons,
          cml_result_bin_error(result, result->A_l, media, m), law);
}

/* Judges all places of a furnace, then whether the worst one deviates more than chance allows among so many
 * tests. */
static void judge_all(struct furnace *f, const struct cml_result *result)
{
    judge(f, 0, cml_result_total(result, CML_TOTAL_TRANSMITTED),
          cml_result_error(result, CML_TOTAL_TRANSMITTED), f->shares[1] / (f->shares[0] + f->shares[1]));
    for (int i = 1; i < f->num_places; i++) judge_medium(f, result, i);
    f->p = f->tested ? cml_sidak(cml_two_sided(f->place[f->worst].z), f->tested) : 1;
}

/* ---- output ---- */

/* Orders places by how far they deviate from even light, the worst first; untested places come last. */
static int compare_places(const void *left, const void *right)
{
    const struct place *a = left, *b = right;
    if (!a->untested != !b->untested) return a->untested ? 1 : -1;
    return fabs(a->z) < fabs(b->z) ? 1 : fabs(a->z) > fabs(b->z) ? -1 : 0;
}

/* Prints a table of the places, the worst ROWS if there are more, and the p-value of all tests together. */
static void print_all(struct furnace *f, uint64_t photons)
{
    printf("%s: %g photons of diffuse light from above and below, on %g x %g cm, without absorption\n",
           f->scene.output, (double)photons, f->size[0], f->size[1]);
    printf("  %-12s %14s %14s %12s %8s\n", "place", "volume cm3", "light / law", "error", "z");
    if (f->num_places > ROWS) qsort(f->place, (size_t)f->num_places, sizeof *f->place, compare_places);
    for (int i = 0; i < f->num_places && i < ROWS; i++) {
        const struct place *place = &f->place[i];
        printf("  %-12s", place->name);
        if (place->volume > 0)
            printf(" %14.6g", place->volume);
        else
            printf(" %14s", "-");
        if (place->untested)
            printf(" not tested: %s\n", place->untested);
        else
            printf(" %14.6f %12.6f %+8.2f\n", place->ratio, place->error, place->z);
    }
    if (f->num_places > ROWS) printf("  the worst %d of %d places\n", ROWS, f->num_places);
    printf("p = %.3g (Sidak over %d tests)\n", f->p, f->tested);
}

/* Describes one layer or body as JSON: the ratio of found to expected light, its error and z = deviation in
 * standard errors. null: the place was not tested. */
static json_t *place_json(const struct place *place)
{
    const bool tested = !place->untested;
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:s?}", "name", place->name, "volume",
                     cml_json_real(place->volume > 0 ? place->volume : NAN), "ratio",
                     cml_json_real(tested ? place->ratio : NAN), "error",
                     cml_json_real(tested ? place->error : NAN), "z", cml_json_real(tested ? place->z : NAN),
                     "untested", place->untested);
}

/* Prints the result of `furnace` as JSON. p: probability that even light deviates this much by chance. */
static cml_status print_json(const struct furnace *f, uint64_t photons, double alpha, struct cml_error *err)
{
    json_t *object =
        json_pack("{s:o, s:o, s:I, s:[f, f], s:i, s:f, s:b}", "scene", cml_json_name(f->scene.file), "output",
                  cml_json_name(f->scene.output), "photons", (json_int_t)photons, "size", f->size[0],
                  f->size[1], "tests", f->tested, "p", f->p, "even", !(f->p < alpha));
    json_t *places = json_array();
    for (int i = 0; i < f->num_places; i++) json_array_append_new(places, place_json(&f->place[i]));
    json_object_set_new(object, "places", places);
    json_object_set_new(object, "version", json_string(cml_version()));
    return cml_json_print(stdout, object, err);
}

/* ---- the command ---- */

/* Reports the result of a furnace, and fails if light is uneven: p below --alpha. The text names the place
 * that deviates most. */
static cml_status publish(const struct cml_options *options, struct furnace *f, uint64_t photons,
                          struct cml_error *err)
{
    char name[sizeof f->place->name];
    snprintf(name, sizeof name, "%s", f->place[f->worst].name);
    const double z = f->place[f->worst].z;
    if (options->json) CML_TRY(print_json(f, photons, options->alpha, err));
    if (!options->json && !options->quiet) print_all(f, photons);
    if (!(f->p < options->alpha)) return CML_OK;
    return cml_fail(err, CML_E_DIFFER, "%s: light is not even: p = %.3g, z = %+.2f in %s", f->scene.output,
                    f->p, z, name);
}

/* Names the places of a furnace whose light is compared: below the scene, the layers, then the bodies. */
static cml_status name_places(struct furnace *f, struct cml_error *err)
{
    f->num_places = 1 + f->scene.num_layers + f->scene.num_bodies;
    CML_TRY(cml_zeros(&f->place, (size_t)f->num_places, sizeof *f->place, "places", err));
    strcpy(f->place[0].name, "below");
    for (int i = 1; i < f->num_places; i++) {
        const bool body = i > f->scene.num_layers;
        snprintf(f->place[i].name, sizeof f->place->name, "%s %d", body ? "body" : "layer",
                 body ? i - f->scene.num_layers : i);
    }
    return CML_OK;
}

/* Makes the furnace of a scene: its diffuse light, the names of its layers and bodies, its surfaces, and the
 * volumes from which the expected light follows. */
static cml_status prepare(const struct cml_scene *scene, struct furnace *f, struct cml_simulation *sim,
                          struct cml_error *err)
{
    CML_TRY(light_scene(scene, f, err));
    CML_TRY(name_places(f, err));
    CML_TRY(cml_simulation_prepare(sim, NULL, err));
    return find_volumes(f, &sim->surfaces, &sim->options->surface, err);
}

/* Flies the photons of a furnace, then judges on rank 0 whether its light is even, and prints the report. */
static cml_status fly(struct furnace *f, struct cml_simulation *sim, struct cml_error *err)
{
    const cml_status status = cml_simulation_fly(sim, 0, err);
    if (status != CML_OK || cml_cluster_rank() != 0) return status;
    CML_TRY(cml_run_verdict(&f->scene, &sim->flown.result, err));
    judge_all(f, &sim->flown.result);
    return publish(sim->options, f, sim->setup.photons, err);
}

/* Tests one scene: fills it with diffuse light and compares the light in each place with theory. */
static cml_status furnace_scene(const struct cml_options *options, const struct cml_scene *scene, int index,
                                struct cml_error *err)
{
    struct furnace f = {0};
    struct cml_simulation sim;
    cml_simulation_begin(options, scene, options->engine_options.seed, (uint32_t)index, &sim);
    sim.setup.scene = &f.scene;
    sim.setup.on_note = NULL;
    cml_status status = cml_cluster_agree(prepare(scene, &f, &sim, err), err);
    if (status == CML_OK) status = fly(&f, &sim, err);
    cml_simulation_clear(&sim);
    free(f.scene.media);
    free(f.place);
    return cml_cluster_agree(status, err);
}

cml_status cml_command_furnace(const struct cml_options *options, struct cml_error *err)
{
    return cml_fly_scenes(options, furnace_scene, err);
}
