/* The JSON lines of run, check and exact. Programs read their keys, so they stay as they are; texts name
 * them. SPDX-License-Identifier: MIT */
#include "output/report_parts.h"

#include "base/json_name.h"
#include "base/settings.h"
#include "scene/body/body_shape.h"
#include "base/version.h"
#include "tally/deal.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Keys keep the order in which they are set (jansson 2.8 and later). */
static void set_real(json_t *object, const char *key, double value)
{
    json_object_set_new(object, key, cml_json_real(value));
}

/* What lists are about; sums NULL: nothing has been flown. */
struct subject {
    const struct cml_scene *scene;
    const struct cml_surface_set *surfaces;
    const struct cml_result *sums;
    uint64_t *dealt;                    /* [num_beams] photons of each beam; owned */
    const int *starts;                  /* [num_beams] the medium that each starts in; NULL: not known */
    const struct cml_mean_shapes *mean; /* NULL: not asked for */
};

/* A list that may be long: its elements are made while they are written, one at a time. In the object `key`
 * holds its place. */
struct list {
    const char *key;
    int count;
    json_t *(*element)(const struct subject *subject, int i);
};

/* What a picture needs of a boundary: its depth, that of the plane in which it goes on, the period of a tile,
 * and where its shape comes from. */
static void set_place(json_t *object, const struct cml_boundary *boundary)
{
    const char *slash = boundary->file ? strrchr(boundary->file, '/') : NULL;
    const char *shape = slash ? slash + 1 : boundary->file ? boundary->file : "heightfield";
    set_real(object, "z", boundary->z);
    set_real(object, "outer_z", cml_outer_depth(boundary));
    if (boundary->form == CML_FORM_PLANE) return;
    json_object_set_new(object, "shape", cml_json_name(shape));
    if (boundary->form == CML_FORM_TILE)
        json_object_set_new(
            object, "period",
            json_pack("[f,f]", cml_tile_period(&boundary->tile, 0), cml_tile_period(&boundary->tile, 1)));
}

/* How a boundary is represented. An unknown bias is infinite. */
static json_t *boundary_json(const struct subject *subject, int b)
{
    const struct cml_surface_def *def = &subject->surfaces->item[b];
    const struct cml_expectation *expect = &def->expectation;
    json_t *object =
        json_pack("{s:s, s:s, s:I, s:f, s:f, s:o, s:f, s:f}", "kind", cml_surface_kind_name(def->kind),
                  "reason", def->reason, "primitives", (json_int_t)def->primitives, "build_s",
                  def->build_seconds, "MiB", def->bytes / 1048576, "bias", cml_json_real(expect->bias),
                  "query_ns", expect->query_ns, "deviation", expect->deviation);
    if (subject->mean) set_real(object, "mean_height", subject->mean->height[b]);
    if (subject->mean) set_place(object, &subject->scene->boundaries[b]);
    return object;
}

/* Key `phase` of a medium that has one: the words of its line. */
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

/* Degrees as the file has them, of up to 14 digits: more is rounding, on the way to radians and back. */
static double in_degrees(double angle)
{
    char digits[32];
    snprintf(digits, sizeof digits, "%.14g", angle * (180 / acos(-1.0)));
    return strtod(digits, NULL);
}

/* Sizes as behind the word. `z` is null where packets start above all surfaces. */
static json_t *beam_json(const struct subject *subject, int k)
{
    static const int sizes[] = {0, 1, 1, 2, 2, 2};
    const struct cml_beam *beam = &subject->scene->beams[k];
    char name[CML_MEDIUM_NAME];
    json_t *size = json_array();
    for (int i = 0; i < sizes[beam->shape]; i++) json_array_append_new(size, json_real(beam->size[i]));
    json_t *object =
        json_pack("{s:s, s:o, s:f, s:f, s:o, s:f, s:f, s:s, s:o, s:b, s:f, s:I}", "shape",
                  cml_beam_word(beam->shape), "size", size, "x", beam->x, "y", beam->y, "z",
                  beam->inside ? json_real(beam->z) : json_null(), "angle", in_degrees(beam->angle),
                  "azimuth", in_degrees(beam->azimuth), "light", cml_light_word(beam->light.kind), "na",
                  beam->light.kind == CML_LIGHT_OF_NA ? json_real(beam->light.na) : json_null(), "radial",
                  beam->radial, "share", subject->scene->shares[k], "photons", (json_int_t)subject->dealt[k]);
    if (!subject->starts) return object;
    cml_medium_name(subject->scene, subject->starts[k], name);
    json_object_set_new(object, "medium", beam->inside ? json_string(name) : json_null());
    set_real(object, "spread",
             in_degrees(cml_light_spread(&beam->light, subject->scene->media[subject->starts[k]].n)));
    return object;
}

/* Who asks for a list of the beams has their photons first. */
static cml_status deal_beams(struct subject *subject, uint64_t photons, struct cml_error *err)
{
    const struct cml_scene *scene = subject->scene;
    const size_t bytes = (size_t)scene->num_beams * sizeof *subject->dealt;
    subject->dealt = malloc(bytes);
    if (!subject->dealt) return cml_fail_memory(err, (double)bytes, "beams");
    return cml_deal_numbers(scene->shares, scene->num_beams, photons, subject->dealt, err);
}

/* The scene's backing; null where it has none. */
static json_t *backing_json(const struct cml_backing_def *backing)
{
    if (backing->kind == CML_BACKING_NONE) return json_null();
    const char *kind = cml_backing_word(backing->kind);
    return backing->kind == CML_BACKING_METAL
               ? json_pack("{s:s, s:f, s:f}", "kind", kind, "n", backing->n, "k", backing->k)
               : json_pack("{s:s, s:f}", "kind", kind, "R", backing->R);
}

/* "layer" or "body", and its number from 1. */
static json_t *host_json(const struct cml_scene *scene, int host)
{
    const int body = host - scene->num_layers - 1;
    return body > 0 ? json_pack("{s:i}", "body", body) : json_pack("{s:i}", "layer", host);
}

/* Corners of the box around a body, cm. */
static void set_box(json_t *object, const struct cml_scene_body *body)
{
    double lower[3], upper[3];
    cml_body_box(body, lower, upper);
    json_object_set_new(object, "lower", json_pack("[f,f,f]", lower[0], lower[1], lower[2]));
    json_object_set_new(object, "upper", json_pack("[f,f,f]", upper[0], upper[1], upper[2]));
}

static json_t *body_json(const struct subject *subject, int k)
{
    const struct cml_scene *scene = subject->scene;
    const struct cml_body_surface *surface = &subject->surfaces->bodies.item[k];
    const int m = cml_body_medium(scene, k);
    const struct cml_medium_def *medium = &scene->media[m];
    json_t *body = json_pack("{s:s, s:s, s:I, s:o, s:f, s:f, s:f, s:f}", "form",
                             cml_body_form_name(scene->bodies[k].form), "kind",
                             cml_surface_kind_name(surface->kind), "primitives",
                             (json_int_t)surface->primitives, "in", host_json(scene, scene->bodies[k].host),
                             "n", medium->n, "mua", medium->mua, "mus", medium->mus, "g", medium->g);
    const struct cml_result *result = subject->sums;
    if (subject->mean) set_box(body, &scene->bodies[k]);
    if (result) set_real(body, "A", cml_result_absorbed(result, m));
    if (result) set_real(body, "A_se", cml_result_absorbed_error(result, m));
    return with_phase(body, medium->phase);
}

/* The main result comes first, as it was written first. */
static json_t *files_json(const struct cml_report *report)
{
    json_t *list = json_array();
    for (int i = 0; i < report->num_files; i++) json_array_append_new(list, cml_json_name(report->files[i]));
    return list;
}

static void set_integer(json_t *object, const char *key, uint64_t value)
{
    json_object_set_new(object, key, json_integer((json_int_t)value));
}

/* NAME of a quantity and what follows it. A key that is there stays where it is. */
static void set_quantity(json_t *object, enum cml_quantity quantity, const char *end, const double *value)
{
    char key[64];
    snprintf(key, sizeof key, "%s%s", cml_quantities[quantity].name, end);
    if (value && !json_object_get(object, key)) set_real(object, key, *value);
}

/* One number, or a list where the quantity has an axis that is not that of detectors. */
static json_t *part_json(const struct cml_outcome *o, enum cml_quantity quantity, const double *values,
                         int part)
{
    const bool one =
        cml_quantities[quantity].axis[0] == CML_AXIS_NONE || cml_quantity_is_of_detector(quantity);
    if (one) return cml_json_real(values[part]);
    json_t *list = json_array();
    for (size_t i = 0; i < cml_outcome_size(o, quantity); i++)
        json_array_append_new(list, cml_json_real(values[i]));
    return list;
}

/* The values and their errors, of every detector where there is one of each. A key that is there stays. */
static void set_parts(json_t *object, const struct cml_outcome *o, enum cml_quantity quantity)
{
    char key[CML_OUTCOME_KEY + 4];
    for (int part = 0; o->value[quantity] && part < cml_outcome_parts(o, quantity); part++) {
        cml_outcome_key(o, quantity, part, key);
        if (!json_object_get(object, key))
            json_object_set_new(object, key, part_json(o, quantity, o->value[quantity], part));
        strcat(key, "_se");
        if (o->error[quantity] && !json_object_get(object, key))
            json_object_set_new(object, key, part_json(o, quantity, o->error[quantity], part));
    }
}

/* Numbers of the table that are new to it come last. `residue` is the imbalance of weight in units of 2^-31
 * packets, 0 unless the program is wrong. */
static void set_results(json_t *object, const struct cml_report *report)
{
    const struct cml_result *result = report->sums;
    const struct cml_outcome *o = &report->outcome;
    for (int i = 0; i < CML_TOTALS; i++) set_quantity(object, (enum cml_quantity)i, "", o->value[i]);
    for (int i = 0; i < CML_TOTALS; i++) set_quantity(object, (enum cml_quantity)i, "_se", o->error[i]);
    set_integer(object, "lost", cml_result_lost(result));
    set_integer(object, "trapped", (uint64_t)result->summary.count[CML_COUNT_TRAPPED]);
    set_integer(object, "shading_overruled", (uint64_t)result->summary.count[CML_COUNT_SHADING_OVERRULED]);
    set_integer(object, "branches", (uint64_t)result->summary.count[CML_COUNT_BRANCHES]);
    set_integer(object, "unsplit", (uint64_t)result->summary.count[CML_COUNT_UNSPLIT]);
    set_integer(object, "clipped", (uint64_t)result->summary.count[CML_COUNT_CLIPPED]);
    set_integer(object, "spent", (uint64_t)result->summary.count[CML_COUNT_SPENT]);
    set_real(object, "residue", cml_result_imbalance(result));
    set_real(object, "overflow_r", cml_result_share(result, CML_BALANCE_OVERFLOW_R));
    for (int i = 0; i < CML_NUM_QUANTITIES; i++)
        if (cml_quantities[i].where & CML_IN_JSON) set_parts(object, o, (enum cml_quantity)i);
}

/* Seconds. `idle` waited for other ranks, `asking` for photons, `sums` summed and wrote checkpoints. */
static json_t *ranks_json(const struct cml_timing *timing)
{
    json_t *list = json_array();
    for (int i = 0; i < timing->ranks; i++) {
        const struct cml_rank_report *rank = &timing->rank[i];
        json_array_append_new(list, json_pack("{s:I, s:I, s:f, s:f, s:f, s:f}", "photons",
                                              (json_int_t)rank->photons, "ranges", (json_int_t)rank->ranges,
                                              "flying", rank->flying, "idle", rank->waiting, "asking",
                                              rank->asking, "sums", rank->summing));
    }
    return list;
}

/* Seconds to a relative standard error of 1 %; null where the total was not seen. */
static void set_seconds_to_error(json_t *object, const struct cml_report *report)
{
    for (int i = 0; i < CML_NUM_GOALS; i++) {
        const double seconds =
            report->timing->seconds * cml_result_times_to(report->sums, cml_goals[i], 0.01);
        set_quantity(object, (enum cml_quantity)cml_goals[i], "_1pc_s", &seconds);
    }
}

/* What depends on the machine and the moment, not on the light. */
static void set_speed(json_t *object, const struct cml_report *report)
{
    const struct cml_timing *timing = report->timing;
    const struct cml_result *sums = report->sums;
    const double steps = cml_result_steps(sums);
    set_real(object, "seconds", timing->seconds);
    set_real(object, "cpu_s", cml_timing_processor(timing));
    set_real(object, "steps", steps);
    set_real(object, "crossings", (double)sums->summary.count[CML_COUNT_BOUNDARY_EVENTS]);
    set_real(object, "queries", (double)sums->summary.count[CML_COUNT_QUERIES]);
    set_real(object, "ns_per_step", steps > 0 ? 1e9 * timing->seconds / steps : 0);
    set_real(object, "photons_per_s", (double)sums->photons / timing->seconds);
    set_seconds_to_error(object, report);
    set_integer(object, "threads", (uint64_t)timing->threads);
    set_integer(object, "ranks", (uint64_t)timing->ranks);
    json_object_set_new(object, "rank_s", ranks_json(timing));
    set_real(object, "idle", cml_timing_idle(timing));
    set_real(object, "communication", cml_timing_communication(timing));
}

/* Totals by adding-doubling, and for each the limit of its error. */
static void set_exact(json_t *object, const struct cml_scene *scene, const struct cml_exact *exact)
{
    const int last = scene->backing.kind == CML_BACKING_NONE ? CML_EXACT_TT : CML_EXACT_BACKING;
    json_t *layers = json_array(), *layer_errors = json_array();
    for (int i = 0; i <= last; i++) set_quantity(object, cml_quantity_of_total(i), "", &exact->value[i]);
    for (int i = 0; i <= last; i++)
        set_quantity(object, cml_quantity_of_total(i), "_error", &exact->error[i]);
    for (int i = CML_EXACT_LAYERS; i < exact->count; i++) {
        json_array_append_new(layers, json_real(exact->value[i]));
        json_array_append_new(layer_errors, json_real(exact->error[i]));
    }
    json_object_set_new(object, "A_l", layers);
    json_object_set_new(object, "A_l_error", layer_errors);
    set_integer(object, "order", (uint64_t)exact->order);
    json_object_set_new(object, "converged", json_boolean(exact->converged));
}

static int totals_of(const struct cml_scene *scene)
{
    return cml_num_totals(scene->backing.kind != CML_BACKING_NONE);
}

/* What a run prints beside its own totals; null where there is none. */
static void set_exact_totals(json_t *object, const struct cml_scene *scene, const struct cml_exact *exact)
{
    const double none = NAN, worst = exact ? cml_exact_worst(exact) : NAN;
    for (int i = 0; i < totals_of(scene); i++)
        set_quantity(object, cml_quantity_of_total(i), "_exact", exact ? &exact->value[i] : &none);
    set_real(object, "exact_error", worst);
}

static int print_list(FILE *stream, const struct list *list, const struct subject *subject)
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

/* Ends the object. lists: [num_lists] */
static cml_status print_with_lists(FILE *stream, json_t *object, const struct list *lists, size_t num_lists,
                                   const struct subject *subject, struct cml_error *err)
{
    const char *key;
    json_t *value;
    int failed = 0;
    char before = '{';
    json_object_set_new(object, "version", json_string(cml_version()));
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
    json_decref(object);
    return failed ? cml_fail_memory(err, 1, "the JSON record") : CML_OK;
}

static cml_status print_object(FILE *stream, json_t *object, struct cml_error *err)
{
    return print_with_lists(stream, object, NULL, 0, NULL, err);
}

cml_status cml_report_exact_json(FILE *stream, const struct cml_scene *scene, const struct cml_exact *exact,
                                 struct cml_error *err)
{
    json_t *object =
        json_pack("{s:o, s:o}", "scene", cml_json_name(scene->file), "output", cml_json_name(scene->output));
    if (!object) return cml_fail_memory(err, 1, "the JSON record");
    set_exact(object, scene, exact);
    return print_object(stream, object, err);
}

static json_t *layer_json(const struct subject *subject, int l)
{
    const struct cml_medium_def *medium = &subject->scene->media[l + 1];
    json_t *object =
        json_pack("{s:f, s:f, s:f, s:f, s:f, s:f}", "n", medium->n, "mua", medium->mua, "mus", medium->mus,
                  "g", medium->g, "d", medium->d, "mean_d", subject->mean->thickness[l]);
    const char *name = cml_layer_name(subject->scene, l + 1);
    if (*name) json_object_set_new(object, "name", json_string(name));
    return with_phase(object, medium->phase);
}

/* null where the scene asks for no map. */
static json_t *map_json(const struct cml_map_def *map)
{
    if (map->nx == 0) return json_null();
    return json_pack("{s:i, s:i, s:f, s:f, s:b, s:b}", "nx", map->nx, "ny", map->ny, "dx", map->dx, "dy",
                     map->dy, "angles", map->angles, "volume", map->volume);
}

/* Sizes as behind the word: radii, lengths, or those of a pixel. */
static json_t *detector_json(const struct subject *subject, int k)
{
    const struct cml_detector_def *d = &subject->scene->detectors[k];
    json_t *object =
        json_pack("{s:s, s:s, s:[f,f], s:i, s:i, s:f, s:f, s:f, s:s, s:f, s:f, s:b}", "name", d->name,
                  "shape", cml_detector_word(d), "size", d->size[0], d->size[1], "nx", d->nx, "ny", d->ny,
                  "x", d->x, "y", d->y, "z", d->z, "side", d->below ? "bottom" : "top", "angle",
                  in_degrees(d->angle), "azimuth", in_degrees(d->azimuth), "diffuse", d->diffuse);
    json_object_set_new(object, "na", d->aimed ? json_real(d->na) : json_null());
    return object;
}

static json_t *saved_json(const struct cml_scene *scene)
{
    const struct cml_saved_def *saved = &scene->saved;
    const struct cml_saved_kind kind = {.limit = cml_most_saved(scene, scene->photons),
                                        .media = (size_t)scene->num_layers + 2 + (size_t)scene->num_bodies};
    return json_pack("{s:o, s:I, s:b, s:I}", "name", cml_json_name(saved->name), "limit",
                     (json_int_t)saved->limit, "detected", saved->detected, "bytes",
                     (json_int_t)cml_saved_file_bytes(&kind));
}

static json_t *flat_json(const struct cml_scene *scene, const struct cml_exact *flat)
{
    if (!flat) return json_null();
    json_t *object = json_object();
    for (int i = 0; i < totals_of(scene); i++)
        set_quantity(object, cml_quantity_of_total(i), "", &flat->value[i]);
    set_real(object, "error", cml_exact_worst(flat));
    return object;
}

cml_status cml_report_check_json(FILE *stream, const struct cml_scene *scene,
                                 const struct cml_surface_set *surfaces, const struct cml_sweep_size *sweep,
                                 double bytes, const int *starts, const struct cml_mean_shapes *mean,
                                 const struct cml_exact *flat, struct cml_error *err)
{
    const char format[] = {scene->format, '\0'};
    struct subject subject = {.scene = scene, .surfaces = surfaces, .starts = starts, .mean = mean};
    const struct list lists[] = {{"layers", scene->num_layers, layer_json},
                                 {"beams", scene->num_beams, beam_json},
                                 {"boundaries", surfaces->count, boundary_json},
                                 {"detectors", scene->num_detectors, detector_json},
                                 {"bodies", scene->num_bodies, body_json}};
    json_t *object = json_pack("{s:o, s:i, s:o, s:s}", "scene", cml_json_name(scene->file), "line",
                               scene->line, "output", cml_json_name(scene->output), "format", format);
    if (!object) return cml_fail_memory(err, 1, "the JSON record");
    set_integer(object, "photons", scene->photons);
    set_real(object, "n_above", scene->media[0].n);
    json_object_set_new(object, "layers", json_null());
    set_real(object, "n_below", scene->media[scene->num_layers + 1].n);
    json_object_set_new(object, "backing", backing_json(&scene->backing));
    json_object_set_new(object, "beams", json_null());
    json_object_set_new(object, "grid",
                        json_pack("{s:f, s:f, s:i, s:i, s:i}", "dz", scene->dz, "dr", scene->dr, "nz",
                                  scene->nz, "nr", scene->nr, "na", scene->na));
    json_object_set_new(object, "map", map_json(&scene->map));
    json_object_set_new(object, "facets", json_boolean(scene->facets));
    if (scene->fluence.line) json_object_set_new(object, "fluence", json_true());
    if (scene->saved.limit) json_object_set_new(object, "saved", saved_json(scene));
    if (scene->directions.nt > 0)
        json_object_set_new(object, "directions",
                            json_pack("{s:i, s:i}", "nt", scene->directions.nt, "np", scene->directions.np));
    if (scene->num_detectors > 0) json_object_set_new(object, "detectors", json_null());
    if (scene->time.gates > 0)
        json_object_set_new(object, "time",
                            json_pack("{s:f, s:i, s:b}", "end", scene->time.end, "gates", scene->time.gates,
                                      "radii", scene->time.radii));
    json_object_set_new(object, "boundaries", json_null());
    if (scene->num_bodies > 0) json_object_set_new(object, "bodies", json_null());
    if (sweep->rows > 0)
        json_object_set_new(object, "sweep",
                            json_pack("{s:i, s:i}", "rows", sweep->rows, "flights", sweep->flights));
    set_integer(object, "memory_bytes", (uint64_t)bytes);
    json_object_set_new(object, "flat", flat_json(scene, flat));
    cml_status status = deal_beams(&subject, scene->photons, err);
    if (status == CML_OK)
        status = print_with_lists(stream, object, lists, sizeof lists / sizeof *lists, &subject, err);
    else
        json_decref(object);
    free(subject.dealt);
    return status;
}

/* What was set from outside the file: all of it are numbers. */
static json_t *settings_json(const char *text)
{
    json_t *object = json_object();
    while (text && *text) {
        char name[CML_SETTING_NAME];
        double value = 0;
        if (sscanf(text, "%63[^ ] = %lf", name, &value) == 2) set_real(object, name, value);
        text += strcspn(text, "\n");
        text += *text == '\n';
    }
    return object;
}

/* What decided the bits, a name or a whole number each. One that is there stays where it is. */
static void set_option(json_t *object, const struct cml_provenance *provenance,
                       enum cml_option_of_bits option)
{
    const struct cml_option_info *info = &cml_options_of_bits[option];
    const double value = provenance->value[option];
    if (!(info->where & CML_IN_JSON) || json_object_get(object, info->name)) return;
    json_object_set_new(object, info->name,
                        info->where & CML_AS_WORD            ? json_string(cml_option_word(option, value))
                        : value == (double)(json_int_t)value ? json_integer((json_int_t)value)
                                                             : json_real(value));
}

/* How many packets were saved, and of how many; and the run's first photons of which none is missing. */
static void set_saved(json_t *object, const struct cml_report *report)
{
    const struct cml_result *sums = report->sums;
    if (!sums->saved) return;
    const struct cml_saved_sums kept = cml_saved_sort(sums->saved);
    json_object_set_new(object, "saved",
                        json_pack("{s:I, s:I, s:I}", "rows", (json_int_t)kept.kept, "found",
                                  (json_int_t)kept.found, "covers", (json_int_t)report->covers));
}

/* One object on one line. */
cml_status cml_report_json(FILE *stream, const struct cml_report *report, struct cml_error *err)
{
    const struct cml_provenance *provenance = report->provenance;
    struct subject subject = {.scene = report->scene, .surfaces = report->surfaces, .sums = report->sums};
    const struct list lists[] = {{"beams", report->scene->num_beams, beam_json},
                                 {"boundaries", report->surfaces->count, boundary_json},
                                 {"bodies", report->scene->num_bodies, body_json}};
    json_t *object = json_pack("{s:o, s:o, s:s}", "scene", cml_json_name(report->scene->file), "output",
                               cml_json_name(report->files[0]), "engine", provenance->engine);
    if (!object) return cml_fail_memory(err, 1, "the JSON record");
    set_integer(object, "photons", report->sums->photons);
    set_option(object, provenance, CML_DECIDES_seed);
    json_object_set_new(object, "row", report->row > 0 ? json_integer(report->row) : json_null());
    json_object_set_new(object, "set", settings_json(report->scene->settings));
    for (int i = 0; i < CML_NUM_OPTIONS_OF_BITS; i++)
        set_option(object, provenance, (enum cml_option_of_bits)i);
    json_object_set_new(object, "beams", json_null());
    json_object_set_new(object, "backing", backing_json(&report->scene->backing));
    json_object_set_new(object, "boundaries", json_null());
    if (report->scene->num_bodies > 0) json_object_set_new(object, "bodies", json_null());
    json_object_set_new(object, "files", files_json(report));
    set_results(object, report);
    cml_status status = deal_beams(&subject, report->sums->photons, err);
    if (status == CML_OK) {
        set_exact_totals(object, report->scene, report->exact);
        set_saved(object, report);
        set_speed(object, report);
        status = print_with_lists(stream, object, lists, sizeof lists / sizeof *lists, &subject, err);
    } else {
        json_decref(object);
    }
    free(subject.dealt);
    return status;
}

/* ---- a finished run's ---- */

/* The end of a path, from behind the slash that so many others follow. */
static const char *end_of(const char *path, int slashes)
{
    const char *end = path + strlen(path);
    while (end > path && (end[-1] != '/' || slashes-- > 0)) end--;
    return end;
}

/* The files as they are called from here, where `folder` is what stands before the output's own name. */
static void rename_files(json_t *files, const char *folder, int slashes)
{
    size_t i;
    json_t *file;
    json_array_foreach(files, i, file)
    {
        const char *path = json_string_value(file);
        if (path) json_array_set_new(files, i, json_sprintf("%s%s", folder, end_of(path, slashes)));
    }
}

cml_status cml_report_json_again(FILE *stream, const char *json, const struct cml_scene *scene,
                                 const char *path, struct cml_error *err)
{
    int slashes = 0;
    for (const char *c = scene->output; *c; c++) slashes += *c == '/';
    json_t *object = json_loads(json, 0, NULL), *files = json_object_get(object, "files");
    char *folder = strndup(path, strlen(path) - strlen(scene->output));
    json_t *named = folder ? cml_json_name(folder) : NULL;
    if (files && named) {
        rename_files(files, json_string_value(named), slashes);
        json_object_set_new(object, "scene", cml_json_name(scene->file));
        json_object_set(object, "output", json_array_get(files, 0));
    }
    free(folder);
    json_decref(named);
    return print_object(stream, object, err);
}
