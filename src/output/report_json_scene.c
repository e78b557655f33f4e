/* JSON of a scene: the parts that check and run have in common, and the record of check.
 * SPDX-License-Identifier: MIT */
#include "output/report_json_scene.h"

#include "base/json_name.h"
#include "input/keys/key.h"
#include "output/report_parts.h"
#include "scene/body/body_shape.h"
#include "scene/contact.h"
#include "base/version.h"
#include "tally/deal.h"

#include <stdlib.h>
#include <string.h>

/* Sets the place of a boundary for pictures: its depth, the depth of the plane in which it continues, the
 * period of a tile, and the source of its shape. */
static void set_place(json_t *object, const struct cml_boundary *boundary)
{
    const char *slash = boundary->file ? strrchr(boundary->file, '/') : NULL;
    const char *shape = slash ? slash + 1 : boundary->file ? boundary->file : "heightfield";
    cml_json_set_real(object, "z", boundary->z);
    cml_json_set_real(object, "outer_z", cml_outer_depth(boundary));
    if (boundary->form == CML_FORM_PLANE) return;
    json_object_set_new(object, "shape", cml_json_name(shape));
    if (boundary->form == CML_FORM_TILE)
        json_object_set_new(
            object, "period",
            json_pack("[f,f]", cml_tile_period(&boundary->tile, 0), cml_tile_period(&boundary->tile, 1)));
}

/* Sets the key `rough` of a boundary or a body with a rough surface. */
static void set_rough(json_t *object, const struct cml_rough_def *rough)
{
    if (!cml_is_rough(rough)) return;
    json_object_set_new(object, "rough",
                        json_pack("{s:s, s:f}", "kind", cml_rough_word(rough->kind), "alpha", rough->alpha));
}

/* Returns an object that describes how a boundary is represented: as plane, cones or mesh, and its bias. An
 * unknown bias is infinite. */
json_t *cml_json_boundary(const struct cml_json_subject *subject, int b)
{
    const struct cml_surface_def *def = &subject->surfaces->item[b];
    const struct cml_expectation *expect = &def->expectation;
    json_t *object =
        json_pack("{s:s, s:s, s:I, s:f, s:f, s:o, s:f, s:f}", "kind", cml_surface_kind_name(def->kind),
                  "reason", def->reason, "primitives", (json_int_t)def->primitives, "build_s",
                  def->build_seconds, "MiB", def->bytes / 1048576, "bias", cml_json_real(expect->bias),
                  "query_ns", expect->query_ns, "deviation", expect->deviation);
    if (subject->mean) cml_json_set_real(object, "mean_height", subject->mean->height[b]);
    if (subject->mean) set_place(object, &subject->scene->boundaries[b]);
    if (subject->mean) set_rough(object, &subject->scene->boundaries[b].rough);
    return object;
}

/* Adds the key `phase`, the words of the phase line, to the object of a medium that has such a line; returns
 * the object. */
static json_t *with_phase(json_t *medium, const struct cml_phase *phase)
{
    char words[128] = "";
    if (!phase) return medium;
    FILE *out = fmemopen(words, sizeof words, "w");
    if (out) {
        cml_phase_print(out, phase, false);
        fclose(out);
    }
    json_object_set_new(medium, "phase", json_string(words));
    return medium;
}

/* Sets in a JSON object the numbers and flags that a line of the scene holds, as in the file. base: the
 * struct with the values; NULL: null for each. */
static void set_keys(json_t *object, enum cml_key_group group, const void *base)
{
    for (const struct cml_key *key = cml_keys_of(group); key->group == group; key++) {
        const bool flag = key->type == CML_KEY_FLAG,
                   whole = key->type == CML_KEY_INT || key->type == CML_KEY_COUNT;
        if (!(key->use & CML_KEY_JSON)) continue;
        json_object_set_new(object, key->name,
                            !base   ? json_null()
                            : flag  ? json_boolean(*(const bool *)((const char *)base + key->member))
                            : whole ? json_integer((json_int_t)cml_key_load(key, base))
                                    : json_real(cml_key_load(key, base)));
    }
}

/* Returns a new JSON object with all keys of a group and their values in the struct `base`. */
static json_t *keys_json(enum cml_key_group group, const void *base)
{
    json_t *object = json_object();
    set_keys(object, group, base);
    return object;
}

/* Returns beam k as an object with the keys of its line. `size` has the numbers behind the shape. `z` is null
 * if packets start above all surfaces. */
json_t *cml_json_beam(const struct cml_json_subject *subject, int k)
{
    static const int sizes[] = {0, 1, 1, 2, 2, 2};
    const struct cml_beam *beam = &subject->scene->beams[k];
    const struct cml_light *light = &beam->light;
    char name[CML_MEDIUM_NAME];
    json_t *size = json_array();
    for (int i = 0; i < sizes[beam->shape]; i++) json_array_append_new(size, json_real(beam->size[i]));
    json_t *object = json_pack("{s:s, s:o}", "shape", cml_beam_word(beam->shape), "size", size);
    if (beam->port) json_object_set_new(object, "port", json_string(beam->port));
    set_keys(object, CML_KEYS_BEAM, beam);
    set_keys(object, CML_KEYS_START, beam->inside ? beam : NULL);
    set_keys(object, CML_KEYS_INSIDE, beam);
    set_keys(object, CML_KEYS_AXIS, beam);
    json_object_set_new(object, "light", json_string(cml_light_word(light->kind)));
    set_keys(object, CML_KEYS_LIGHT, light->kind == CML_LIGHT_OF_NA ? light : NULL);
    json_object_set_new(object, "radial", json_boolean(beam->radial));
    set_keys(object, CML_KEYS_SHARE, &subject->scene->shares[k]);
    json_object_set_new(object, "photons", json_integer((json_int_t)subject->dealt[k]));
    if (!subject->starts) return object;
    cml_medium_name(subject->scene, subject->starts[k], name);
    json_object_set_new(object, "medium", beam->inside ? json_string(name) : json_null());
    const double n =
        beam->port ? cml_beam_index(subject->scene, beam) : subject->scene->media[subject->starts[k]].n;
    cml_json_set_real(object, "spread", cml_key_degrees(cml_light_spread(light, n)));
    return object;
}

json_t *cml_json_backing(const struct cml_backing_def *backing)
{
    if (backing->kind == CML_BACKING_NONE) return json_null();
    const char *kind = cml_backing_word(backing->kind);
    json_t *object = json_pack("{s:s}", "kind", kind);
    if (backing->kind == CML_BACKING_METAL)
        set_keys(object, CML_KEYS_METAL, backing);
    else
        cml_json_set_real(object, "R", backing->R);
    return object;
}

/* Returns "layer" or "body" with its number, from 1. */
static json_t *host_json(const struct cml_scene *scene, int host)
{
    const int body = host - scene->num_layers - 1;
    return body > 0 ? json_pack("{s:i}", "body", body) : json_pack("{s:i}", "layer", host);
}

/* Returns the two corners of the box around a body, cm. */
static void set_box(json_t *object, const struct cml_scene_body *body)
{
    double lower[3], upper[3];
    cml_body_box(body, lower, upper);
    json_object_set_new(object, "lower", json_pack("[f,f,f]", lower[0], lower[1], lower[2]));
    json_object_set_new(object, "upper", json_pack("[f,f,f]", upper[0], upper[1], upper[2]));
}

/* Describes body k as JSON: form, representation, host and optical properties. `check --json` adds the box
 * and the roughness (subject->mean is set); the record of a run adds the absorption (subject->sums is
 * set). */
json_t *cml_json_body(const struct cml_json_subject *subject, int k)
{
    const struct cml_scene *scene = subject->scene;
    const struct cml_body_surface *surface = &subject->surfaces->bodies.item[k];
    const int m = cml_body_medium(scene, k);
    json_t *body = json_pack("{s:s, s:s, s:I, s:o}", "form", cml_body_form_name(scene->bodies[k].form),
                             "kind", cml_surface_kind_name(surface->kind), "primitives",
                             (json_int_t)surface->primitives, "in", host_json(scene, scene->bodies[k].host));
    set_keys(body, CML_KEYS_MEDIUM, &scene->media[m]);
    const struct cml_result *result = subject->sums;
    if (subject->mean) set_box(body, &scene->bodies[k]);
    if (subject->mean) set_rough(body, &scene->media[m].rough);
    if (result) cml_json_set_real(body, "A", cml_result_absorbed(result, m));
    if (result) cml_json_set_real(body, "A_se", cml_result_absorbed_error(result, m));
    return with_phase(body, scene->media[m].phase);
}

/* Describes layer l (0 is the top one) as JSON for `check --json`: optical properties, mean thickness, name
 * and phase function. */
static json_t *layer_json(const struct cml_json_subject *subject, int l)
{
    const struct cml_medium_def *medium = &subject->scene->media[l + 1];
    json_t *object = keys_json(CML_KEYS_MEDIUM, medium);
    set_keys(object, CML_KEYS_LAYER, medium);
    cml_json_set_real(object, "mean_d", subject->mean->thickness[l]);
    const char *name = cml_layer_name(subject->scene, l + 1);
    if (*name) json_object_set_new(object, "name", json_string(name));
    return with_phase(object, medium->phase);
}

/* Returns group k of detectors as an object. */
static json_t *group_json(const struct cml_scene *scene, int k)
{
    const struct cml_detector_def *d = &scene->detectors[k];
    json_t *members = json_array();
    for (int i = 0; i < cml_num_areas(scene); i++)
        if (scene->detectors[i].in_group == k + 1)
            json_array_append_new(members, json_string(scene->detectors[i].name));
    return json_pack("{s:s, s:s, s:s, s:o}", "name", d->name, "shape", cml_detector_word(d), "side",
                     d->below ? "bottom" : "top", "members", members);
}

/* Returns detector k as an object. `size` has the radii or lengths in the order of the line; for a map, those
 * of a pixel. */
static json_t *detector_json(const struct cml_json_subject *subject, int k)
{
    const struct cml_detector_def *d = &subject->scene->detectors[k];
    if (d->shape == CML_DETECTOR_GROUP) return group_json(subject->scene, k);
    json_t *object =
        json_pack("{s:s, s:s, s:[f,f], s:i, s:i}", "name", d->name, "shape", cml_detector_word(d), "size",
                  d->size[0], d->size[1], "nx", d->nx, "ny", d->ny);
    if (d->port) json_object_set_new(object, "port", json_string(d->port));
    set_keys(object, CML_KEYS_DETECTOR, d);
    json_object_set_new(object, "side", json_string(d->below ? "bottom" : "top"));
    set_keys(object, CML_KEYS_AIM, d);
    set_keys(object, CML_KEYS_SIGHT, d);
    json_object_set_new(object, "na", d->aimed ? json_real(d->na) : json_null());
    return object;
}

/* Returns face or port k as an object. `size` has the numbers behind the shape; a face over the whole plane
 * has no shape. `n` is the index of a port, or the real part of a metal's. */
static json_t *contact_json(const struct cml_json_subject *subject, int k)
{
    const struct cml_contact_def *c = &subject->scene->contacts[k];
    const struct cml_backing_def *face = &c->face;
    const bool round = c->shape == CML_DETECTOR_RING, disk = round && c->size[0] == 0,
               metal = face->kind == CML_BACKING_METAL;
    json_t *size = json_array();
    for (int i = disk ? 1 : 0; !c->whole && i < 2; i++) json_array_append_new(size, json_real(c->size[i]));
    json_t *object =
        json_pack("{s:s, s:o, s:o, s:o}", "kind", c->port ? "port" : "face", "name",
                  c->port ? json_string(c->name) : json_null(), "shape",
                  c->whole ? json_null() : json_string(cml_outline_word(round, c->size)), "size", size);
    set_keys(object, CML_KEYS_CONTACT, c);
    json_object_set_new(object, "n", c->port ? json_real(c->n) : metal ? json_real(face->n) : json_null());
    json_object_set_new(object, "r", c->port || metal ? json_null() : json_real(face->R));
    json_object_set_new(object, "law", c->port ? json_null() : json_string(cml_backing_word(face->kind)));
    json_object_set_new(object, "k", metal ? json_real(face->k) : json_null());
    return object;
}

/* Describes the line `saved` as JSON: the name of its file, the limit of packets, and the largest size of
 * the file in bytes. */
static json_t *saved_json(const struct cml_scene *scene)
{
    const struct cml_saved_def *saved = &scene->saved;
    const struct cml_saved_kind kind = {.limit = cml_most_saved(scene, scene->photons),
                                        .media = (size_t)scene->num_layers + 2 + (size_t)scene->num_bodies};
    return json_pack("{s:o, s:I, s:b, s:I}", "name", cml_json_name(saved->name), "limit",
                     (json_int_t)saved->limit, "detected", saved->detected, "bytes",
                     (json_int_t)cml_saved_file_bytes(&kind));
}

/* Describes the exact totals of the flat scene as JSON; null if they are not known. */
static json_t *flat_json(const struct cml_scene *scene, const struct cml_exact *flat)
{
    if (!flat) return json_null();
    json_t *object = json_object();
    for (int i = 0; i < CML_NUM_TOTALS; i++)
        if (cml_json_has_exact(scene, i))
            cml_json_set_real(object, cml_quantities[cml_quantity_of_total(i)].name, flat->value[i]);
    cml_json_set_real(object, "error", cml_exact_worst(flat));
    return object;
}

/* Deals the photons to the beams. A list of beams is printed only after this call. */
static cml_status deal_beams(struct cml_json_subject *subject, uint64_t photons, struct cml_error *err)
{
    const struct cml_scene *scene = subject->scene;
    CML_TRY(cml_zeros(&subject->dealt, (size_t)scene->num_beams, sizeof *subject->dealt, "beams", err));
    return cml_deal_numbers(scene->shares, scene->num_beams, photons, subject->dealt, err);
}

/* Prints an array of JSON elements one by one, because a long list as one object would take much memory.
 * Returns nonzero if an element could not be made or printed. */
static int print_list(FILE *stream, const struct cml_json_list *list, const struct cml_json_subject *subject)
{
    int failed = 0;
    fputc('[', stream);
    for (int i = 0; i < list->count && !failed; i++) {
        json_t *element = list->element(subject, i);
        if (i > 0) fputc(',', stream);
        failed = !element || json_dumpf(element, stream, JSON_COMPACT);
        json_decref(element);
    }
    fputc(']', stream);
    return failed;
}

/* Prints an object member by member. A member that `lists` names is printed element by element, so that long
 * lists are never held in memory. */
static cml_status print_object(FILE *stream, json_t *object, const struct cml_json_list *lists,
                               size_t num_lists, const struct cml_json_subject *subject,
                               struct cml_error *err)
{
    const char *key;
    json_t *value;
    int failed = 0;
    char before = '{';
    json_object_foreach(object, key, value)
    {
        size_t i = 0;
        while (i < num_lists && strcmp(lists[i].key, key) != 0) i++;
        fprintf(stream, "%c\"%s\":", before, key);
        if (!failed && i < num_lists)
            failed = print_list(stream, &lists[i], subject);
        else if (!failed)
            failed = json_dumpf(value, stream, JSON_COMPACT | JSON_ENCODE_ANY);
        before = ',';
    }
    fputs("}\n", stream);
    fflush(stream);
    return failed ? cml_fail_memory(err, 1, "the JSON record") : CML_OK;
}

/* Prints a JSON object, in which a null member named like one of the lists is replaced by that list's
 * elements. `photons` are dealt to the beams, whose numbers the beams' elements show. Frees the object. */
cml_status cml_json_print_lists(FILE *stream, json_t *object, const struct cml_json_list *lists,
                                size_t num_lists, struct cml_json_subject *subject, uint64_t photons,
                                struct cml_error *err)
{
    json_object_set_new(object, "version", json_string(cml_version()));
    cml_status status = deal_beams(subject, photons, err);
    if (status == CML_OK) status = print_object(stream, object, lists, num_lists, subject, err);
    free(subject->dealt);
    subject->dealt = NULL;
    json_decref(object);
    return status;
}

cml_status cml_report_check_json(FILE *stream, const struct cml_scene *scene,
                                 const struct cml_surface_set *surfaces, const struct cml_sweep_size *sweep,
                                 double bytes, const int *starts, const struct cml_mean_shapes *mean,
                                 const struct cml_exact *flat, struct cml_error *err)
{
    const char format[] = {scene->format, '\0'};
    struct cml_json_subject subject = {.scene = scene, .surfaces = surfaces, .starts = starts, .mean = mean};
    const struct cml_json_list lists[] = {{"layers", scene->num_layers, layer_json},
                                          {"beams", scene->num_beams, cml_json_beam},
                                          {"boundaries", surfaces->count, cml_json_boundary},
                                          {"detectors", scene->num_detectors, detector_json},
                                          {"top", scene->num_contacts, contact_json},
                                          {"bodies", scene->num_bodies, cml_json_body}};
    json_t *object = json_pack("{s:o, s:i, s:o, s:s}", "scene", cml_json_name(scene->file), "line",
                               scene->line, "output", cml_json_name(scene->output), "format", format);
    if (!object) return cml_fail_memory(err, 1, "the JSON record");
    set_keys(object, CML_KEYS_PHOTONS, scene);
    cml_json_set_real(object, "n_above", scene->media[0].n);
    if (scene->num_contacts > 0) json_object_set_new(object, "top", json_null());
    json_object_set_new(object, "layers", json_null());
    cml_json_set_real(object, "n_below", scene->media[scene->num_layers + 1].n);
    json_object_set_new(object, "backing", cml_json_backing(&scene->backing));
    json_object_set_new(object, "beams", json_null());
    json_t *grid = keys_json(CML_KEYS_STEPS, scene);
    set_keys(grid, CML_KEYS_BINS, scene);
    json_object_set_new(object, "grid", grid);
    json_object_set_new(object, "map",
                        scene->map.nx > 0 ? keys_json(CML_KEYS_MAP, &scene->map) : json_null());
    json_object_set_new(object, "facets", json_boolean(scene->facets));
    if (scene->fluence.line)
        json_object_set_new(object, "fluence", scene->fluence.times ? json_string("time") : json_true());
    if (scene->saved.limit) json_object_set_new(object, "saved", saved_json(scene));
    if (scene->directions.nt > 0)
        json_object_set_new(object, "directions", keys_json(CML_KEYS_DIRECTIONS, &scene->directions));
    if (scene->num_detectors > 0) json_object_set_new(object, "detectors", json_null());
    if (scene->time.gates > 0) json_object_set_new(object, "time", keys_json(CML_KEYS_TIME, &scene->time));
    json_object_set_new(object, "boundaries", json_null());
    if (scene->num_bodies > 0) json_object_set_new(object, "bodies", json_null());
    if (sweep->rows > 0)
        json_object_set_new(object, "sweep",
                            json_pack("{s:i, s:i}", "rows", sweep->rows, "flights", sweep->flights));
    cml_json_set_integer(object, "memory_bytes", (uint64_t)bytes);
    json_object_set_new(object, "flat", flat_json(scene, flat));
    return cml_json_print_lists(stream, object, lists, sizeof lists / sizeof *lists, &subject, scene->photons,
                                err);
}
