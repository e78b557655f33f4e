/* JSON of the results of `run` and `exact`, and of a finished run that --resume finds. Other programs read
 * the keys, so no key is ever renamed; samples/manual/output/json.md lists them. SPDX-License-Identifier: MIT
 */
#include "output/report_json_scene.h"

#include "base/json_name.h"
#include "base/settings.h"
#include "base/version.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Returns the names of all files written, the main result first. */
static json_t *files_json(const struct cml_report *report)
{
    json_t *list = json_array();
    for (int i = 0; i < report->num_files; i++) json_array_append_new(list, cml_json_name(report->files[i]));
    return list;
}

/* Sets a key of the JSON object, the quantity's name and `end`, to a value, unless the object has the key. */
static void set_quantity(json_t *object, enum cml_quantity quantity, const char *end, const double *value)
{
    char key[64];
    snprintf(key, sizeof key, "%s%s", cml_quantities[quantity].name, end);
    if (value && !json_object_get(object, key)) cml_json_set_real(object, key, *value);
}

/* Returns one number, or a list if the quantity has an axis other than that of detectors. */
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

/* Sets the values and errors of a quantity, with a key for each detector if detectors are its axis. Keys that
 * the object has are kept. */
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

/* Sets all results. Quantities that were added later come last. `residue` is the imbalance of weight in units
 * of 2^-31 packets, 0 unless the program is wrong. */
static void set_results(json_t *object, const struct cml_report *report)
{
    const struct cml_result *result = report->sums;
    const struct cml_outcome *o = &report->outcome;
    for (int i = 0; i < CML_TOTALS; i++) set_quantity(object, (enum cml_quantity)i, "", o->value[i]);
    for (int i = 0; i < CML_TOTALS; i++) set_quantity(object, (enum cml_quantity)i, "_se", o->error[i]);
    cml_json_set_integer(object, "lost", cml_result_lost(result));
    cml_json_set_integer(object, "trapped", (uint64_t)result->summary.count[CML_COUNT_TRAPPED]);
    cml_json_set_integer(object, "shading_overruled",
                         (uint64_t)result->summary.count[CML_COUNT_SHADING_OVERRULED]);
    cml_json_set_integer(object, "branches", (uint64_t)result->summary.count[CML_COUNT_BRANCHES]);
    cml_json_set_integer(object, "unsplit", (uint64_t)result->summary.count[CML_COUNT_UNSPLIT]);
    cml_json_set_integer(object, "clipped", (uint64_t)result->summary.count[CML_COUNT_CLIPPED]);
    cml_json_set_integer(object, "spent", (uint64_t)result->summary.count[CML_COUNT_SPENT]);
    cml_json_set_real(object, "residue", cml_result_imbalance(result));
    cml_json_set_real(object, "overflow_r", cml_result_share(result, CML_BALANCE_OVERFLOW_R));
    for (int i = 0; i < CML_NUM_QUANTITIES; i++)
        if (cml_quantities[i].where & CML_IN_JSON) set_parts(object, o, (enum cml_quantity)i);
}

/* Returns a list of the ranks' times in seconds: `idle` is the wait for other ranks, `asking` the wait for
 * photons, and `sums` the time for summing results and writing checkpoints. */
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

/* Sets the seconds that a run needs to a relative standard error of 1 %; null if no packet contributed. */
static void set_seconds_to_error(json_t *object, const struct cml_report *report)
{
    for (int i = 0; i < CML_NUM_GOALS; i++) {
        const double seconds =
            report->timing->seconds * cml_result_times_to(report->sums, cml_goals[i], 0.01);
        set_quantity(object, (enum cml_quantity)cml_goals[i], "_1pc_s", &seconds);
    }
}

/* Sets the numbers that depend on the machine and the load, not on the scene. */
static void set_speed(json_t *object, const struct cml_report *report)
{
    const struct cml_timing *timing = report->timing;
    const struct cml_result *sums = report->sums;
    const double steps = cml_result_steps(sums);
    cml_json_set_real(object, "seconds", timing->seconds);
    cml_json_set_real(object, "cpu_s", cml_timing_processor(timing));
    cml_json_set_real(object, "steps", steps);
    cml_json_set_real(object, "crossings", (double)sums->summary.count[CML_COUNT_BOUNDARY_EVENTS]);
    cml_json_set_real(object, "queries", (double)sums->summary.count[CML_COUNT_QUERIES]);
    cml_json_set_real(object, "ns_per_step", steps > 0 ? 1e9 * timing->seconds / steps : 0);
    cml_json_set_real(object, "photons_per_s", (double)sums->photons / timing->seconds);
    set_seconds_to_error(object, report);
    cml_json_set_integer(object, "threads", (uint64_t)timing->threads);
    cml_json_set_integer(object, "ranks", (uint64_t)timing->ranks);
    json_object_set_new(object, "rank_s", ranks_json(timing));
    cml_json_set_real(object, "idle", cml_timing_idle(timing));
    cml_json_set_real(object, "communication", cml_timing_communication(timing));
}

/* Sets the totals by adding-doubling, each with the limit of its error, and the boundaries whose shape is
 * ignored. */
static void set_exact(json_t *object, const struct cml_scene *scene, const struct cml_exact *exact)
{
    const int last = scene->backing.kind == CML_BACKING_NONE ? CML_EXACT_TT : CML_EXACT_BACKING;
    json_t *layers = json_array(), *layer_errors = json_array(), *planes = json_array();
    for (int i = 0; i <= last; i++) set_quantity(object, cml_quantity_of_total(i), "", &exact->value[i]);
    for (int i = 0; i <= last; i++)
        set_quantity(object, cml_quantity_of_total(i), "_error", &exact->error[i]);
    for (int i = CML_EXACT_LAYERS; i < exact->count; i++) {
        json_array_append_new(layers, json_real(exact->value[i]));
        json_array_append_new(layer_errors, json_real(exact->error[i]));
    }
    for (int b = 0; b <= scene->num_layers; b++)
        if (cml_boundary_has_shape(&scene->boundaries[b])) json_array_append_new(planes, json_integer(b));
    json_object_set_new(object, "A_l", layers);
    json_object_set_new(object, "A_l_error", layer_errors);
    json_object_set_new(object, "planes", planes);
    cml_json_set_integer(object, "order", (uint64_t)exact->order);
    json_object_set_new(object, "converged", json_boolean(exact->converged));
}

/* Sets the totals of a flat scene by adding-doubling, which a run prints beside its own; null if there are
 * none. */
static void set_exact_totals(json_t *object, const struct cml_scene *scene, const struct cml_exact *exact)
{
    const double none = NAN, worst = exact ? cml_exact_worst(exact) : NAN;
    for (int i = 0; i < CML_NUM_TOTALS; i++)
        if (cml_json_has_exact(scene, i))
            set_quantity(object, cml_quantity_of_total(i), "_exact", exact ? &exact->value[i] : &none);
    cml_json_set_real(object, "exact_error", worst);
}

cml_status cml_report_exact_json(FILE *stream, const struct cml_scene *scene, const struct cml_exact *exact,
                                 struct cml_error *err)
{
    json_t *object =
        json_pack("{s:o, s:o}", "scene", cml_json_name(scene->file), "output", cml_json_name(scene->output));
    if (!object) return cml_fail_memory(err, 1, "the JSON record");
    set_exact(object, scene, exact);
    json_object_set_new(object, "version", json_string(cml_version()));
    return cml_json_print(stream, object, err);
}

/* Returns an object with the values of --set and of a row of a sweep, from lines "NAME = NUMBER". */
static json_t *settings_json(const char *text)
{
    json_t *object = json_object();
    while (text && *text) {
        char name[CML_SETTING_NAME];
        double value = 0;
        if (sscanf(text, "%63[^ ] = %lf", name, &value) == 2) cml_json_set_real(object, name, value);
        text += strcspn(text, "\n");
        text += *text == '\n';
    }
    return object;
}

/* Sets the options that decide the bits of a result, each a name or a whole number. Keys that the object has
 * are kept. */
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

/* Sets the numbers of saved packets and of packets that could have been saved, and how many of the run's
 * first photons are complete. */
static void set_saved(json_t *object, const struct cml_report *report)
{
    const struct cml_result *sums = report->sums;
    if (!sums->saved) return;
    const struct cml_saved_sums kept = cml_saved_sort(sums->saved);
    json_object_set_new(object, "saved",
                        json_pack("{s:I, s:I, s:I}", "rows", (json_int_t)kept.kept, "found",
                                  (json_int_t)kept.found, "covers", (json_int_t)report->covers));
}

/* Long lists stand as null in the object and are filled in when it is printed. */
cml_status cml_report_json(FILE *stream, const struct cml_report *report, struct cml_error *err)
{
    const struct cml_provenance *provenance = report->provenance;
    struct cml_json_subject subject = {
        .scene = report->scene, .surfaces = report->surfaces, .sums = report->sums};
    const struct cml_json_list lists[] = {{"beams", report->scene->num_beams, cml_json_beam},
                                          {"boundaries", report->surfaces->count, cml_json_boundary},
                                          {"bodies", report->scene->num_bodies, cml_json_body}};
    json_t *object =
        json_pack("{s:o, s:o, s:s}", "scene", cml_json_name(report->scene->file), "output",
                  cml_json_name(report->num_files > 0 ? report->files[0] : report->scene->output), "engine",
                  provenance->engine);
    if (!object) return cml_fail_memory(err, 1, "the JSON record");
    cml_json_set_integer(object, "photons", report->sums->photons);
    set_option(object, provenance, CML_DECIDES_seed);
    json_object_set_new(object, "row", report->row > 0 ? json_integer(report->row) : json_null());
    json_object_set_new(object, "set", settings_json(report->scene->settings));
    for (int i = 0; i < CML_NUM_OPTIONS_OF_BITS; i++)
        set_option(object, provenance, (enum cml_option_of_bits)i);
    json_object_set_new(object, "beams", json_null());
    json_object_set_new(object, "backing", cml_json_backing(&report->scene->backing));
    json_object_set_new(object, "boundaries", json_null());
    if (report->scene->num_bodies > 0) json_object_set_new(object, "bodies", json_null());
    json_object_set_new(object, "files", files_json(report));
    set_results(object, report);
    set_exact_totals(object, report->scene, report->exact);
    set_saved(object, report);
    set_speed(object, report);
    return cml_json_print_lists(stream, object, lists, sizeof lists / sizeof *lists, &subject,
                                report->sums->photons, err);
}

/* Returns the end of a path that has `slashes` slashes. */
static const char *end_of(const char *path, int slashes)
{
    const char *end = path + strlen(path);
    while (end > path && (end[-1] != '/' || slashes-- > 0)) end--;
    return end;
}

/* Renames files for the current directory: `folder` is the part of the path before the output's own name. */
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
    json_object_set_new(object, "version", json_string(cml_version()));
    return cml_json_print(stream, object, err);
}
