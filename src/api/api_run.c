/* Runs of the C library, and their results as arrays. SPDX-License-Identifier: MIT */
#include "api/api_parts.h"

#include "flights/one_run.h"
#include "flights/sweep.h"
#include "flights/sweep_flights.h"
#include "run/identity.h"
#include "simulation/beam_notes.h"
#include "simulation/simulation.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* An array as callers see it. Its values are computed when they are first asked for. */
struct item {
    const struct cml_field *field, *errors; /* errors NULL: none */
    struct cml_field axis;                  /* the field of an axis, to which `field` then points */
    double *value, *error;
};

/* Whoever hears of a flight, and may cancel it. */
struct listener {
    clm_progress *progress;
    void *context;
    struct cml_note_receiver notes;
    atomic_bool cancelled;
};

struct clm_run {
    struct listener listener;
    struct cml_api_words words;
    struct cml_options options;
    struct cml_scene scene;
    char *inputs; /* lines of the identity */
    struct cml_simulation sim;
    struct cml_report report; /* what has flown, and its arrays */
    struct cml_report_arrays arrays;
    struct item *item; /* [num_items] arrays, then axes */
    int num_items;
    char *json;
};

/* ---- opening ---- */

static void on_progress(void *context, const struct cml_progress *now)
{
    struct listener *listener = context;
    if (listener->progress && listener->progress(listener->context, now->done, now->total, now->seconds))
        atomic_store(&listener->cancelled, true);
}

static bool is_cancelled(void *context)
{
    struct listener *listener = context;
    return atomic_load(&listener->cancelled);
}

/* Any thread of a flight may have a note. */
static void on_note(void *context, const char *text)
{
    const struct listener *listener = context;
    if (listener->notes.to) listener->notes.to(listener->notes.context, text);
}

/* Makes the surfaces of a run, and shares those of runs before that have the same shapes. */
static cml_status prepare(struct clm_run *run, struct cml_surface_set *shared, struct cml_error *err)
{
    struct cml_surface_options options = run->options.surface;
    struct cml_surface_set kept;
    CML_TRY(cml_simulation_prepare(&run->sim, shared->count > 0 ? shared : NULL, err));
    options.shared = &run->sim.surfaces;
    CML_TRY(cml_surfaces_create(&run->scene, &options, &kept, err));
    cml_surfaces_free(shared);
    *shared = kept;
    return CML_OK;
}

static cml_status open_run(struct clm_scene *scene, int index, const char *const *options,
                           struct clm_run *run, struct cml_error *err)
{
    struct cml_run_setup *setup = &run->sim.setup;
    CML_TRY(cml_api_check_run(scene, index, err));
    CML_TRY(cml_api_parse(scene->list.scenes[index].file, &scene->words, options, false, &run->words,
                          &run->options, err));
    CML_TRY(cml_check_flight_options(&run->options, err));
    CML_TRY(cml_sweep_check_options(&run->options, err));
    CML_TRY(cml_copy_scene(&run->options, cml_api_settings(scene, index), NULL, &scene->inputs,
                           &scene->list.scenes[index], &run->scene, err));
    CML_TRY(cml_check_differentiated(&run->options, &run->scene, err));
    CML_TRY(cml_identity_inputs(&scene->inputs, &run->inputs, err));
    cml_simulation_begin(&run->options, &run->scene, run->options.engine_options.seed, (uint32_t)index,
                         &run->sim);
    setup->on_progress = on_progress;
    setup->cancelled = is_cancelled;
    setup->on_note = on_note;
    setup->context = &run->listener;
    CML_TRY(prepare(run, &scene->surfaces[index], err));
    return cml_note_beam(&run->scene, &run->sim.surfaces, NULL, err);
}

CML_API int clm_run_open(struct clm_scene *scene, int index, const char *const *options, struct clm_run **out)
{
    CML_API_CALL();
    struct clm_run *run = *out = calloc(1, sizeof *run);
    if (!run) return cml_fail_memory(&cml_api_error, sizeof *run, "a run");
    const cml_status status = open_run(scene, index, options, run, &cml_api_error);
    if (status == CML_OK) return CML_OK;
    clm_run_free(run);
    *out = NULL;
    return status;
}

CML_API void clm_run_on_progress(struct clm_run *run, clm_progress *progress, void *context)
{
    run->listener.progress = progress;
    run->listener.context = context;
}

/* ---- results ---- */

/* Frees all that callers see of a result. */
static void clear_view(struct clm_run *run)
{
    for (int i = 0; i < run->num_items; i++) {
        free(run->item[i].value);
        free(run->item[i].error);
    }
    free(run->item);
    free(run->json);
    run->item = NULL;
    run->num_items = 0;
    run->json = NULL;
    cml_report_arrays_clear(&run->arrays);
    cml_report_clear(&run->report);
}

static struct item *find_item(const struct clm_run *run, const char *name)
{
    for (int i = 0; i < run->num_items; i++)
        if (strcmp(run->item[i].field->name, name) == 0) return &run->item[i];
    return NULL;
}

static void axis_values(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_axis *axis = context;
    for (size_t i = begin; i < begin + count; i++)
        *out++ = axis->values ? axis->values[i] : axis->first + (double)i * axis->step;
}

/* Adds an axis, unless an array or an axis has its name. */
static void add_axis(struct clm_run *run, const struct cml_axis *axis)
{
    if (find_item(run, axis->name)) return;
    struct item *item = &run->item[run->num_items++];
    item->axis = (struct cml_field){.long_name = axis->long_name,
                                    .units = axis->units,
                                    .num_axes = 1,
                                    .axis = {axis},
                                    .values = axis_values,
                                    .context = axis};
    strncat(item->axis.name, axis->name, sizeof item->axis.name - 1);
    item->field = &item->axis;
}

/* Lists arrays and axes. A field of standard errors belongs to the array before it. */
static cml_status list_items(struct clm_run *run, struct cml_error *err)
{
    const struct cml_report_arrays *arrays = &run->arrays;
    size_t most = (size_t)arrays->num_fields;
    for (int i = 0; i < arrays->num_fields; i++) most += (size_t)arrays->field[i].num_axes;
    run->item = calloc(most, sizeof *run->item);
    if (!run->item) return cml_fail_memory(err, arrays->num_fields, "a list of arrays");
    for (int i = 0; i < arrays->num_fields; i++) {
        const struct cml_field *field = &arrays->field[i], *before = i > 0 ? field - 1 : NULL;
        if (field->num_axes == 1 && strcmp(field->name, field->axis[0]->name) == 0) continue;
        if (before && before->errors && strcmp(before->errors, field->name) == 0)
            run->item[run->num_items - 1].errors = field;
        else
            run->item[run->num_items++].field = field;
    }
    for (int i = 0; i < arrays->num_fields; i++)
        for (int k = 0; k < arrays->field[i].num_axes; k++) add_axis(run, arrays->field[i].axis[k]);
    return CML_OK;
}

/* Makes what callers see of the run's report. */
static cml_status view(struct clm_run *run, struct cml_error *err)
{
    struct cml_record record = {0};
    CML_TRY(cml_report_arrays(&run->report, &run->arrays, err));
    CML_TRY(list_items(run, err));
    const cml_status status = cml_report_record(&run->report, &record, err);
    run->json = record.json;
    return status;
}

/* ---- flight ---- */

static cml_status fly(struct clm_run *run, uint64_t photons, struct cml_error *err)
{
    if (!run->sim.options)
        return cml_fail(err, CML_E_INPUT, "a row of a sweep (expected a run of clm_run_open)");
    run->listener.notes = cml_notes;
    atomic_store(&run->listener.cancelled, false);
    CML_TRY(cml_simulation_fly(&run->sim, photons, err));
    clear_view(run);
    CML_TRY(cml_simulation_identify(&run->sim, run->inputs, err));
    run->report = cml_simulation_report(&run->sim);
    CML_TRY(view(run, err));
    return cml_run_verdict(&run->scene, run->report.sums, err);
}

CML_API int clm_run_fly(struct clm_run *run, uint64_t photons)
{
    CML_API_CALL();
    return fly(run, photons, &cml_api_error);
}

CML_API void clm_run_free(struct clm_run *run)
{
    if (!run) return;
    clear_view(run);
    cml_simulation_clear(&run->sim);
    cml_scene_clear(&run->scene);
    free(run->inputs);
    cml_api_words_clear(&run->words);
    free(run);
}

/* ---- arrays ---- */

/* Computes the values of a field, rounded as a file has them. */
static cml_status take_values(const struct cml_field *field, double **value, struct cml_error *err)
{
    const size_t count = cml_field_size(field);
    if (*value) return CML_OK;
    *value = malloc((count + 1) * sizeof **value);
    if (!*value) return cml_fail_memory(err, (double)count * sizeof **value, field->name);
    field->values(field->context, 0, count, *value);
    for (size_t i = 0; field->single && i < count; i++) (*value)[i] = (float)(*value)[i];
    return CML_OK;
}

static cml_status show(struct item *item, struct clm_array *array, struct cml_error *err)
{
    const struct cml_field *field = item->field;
    CML_TRY(take_values(field, &item->value, err));
    if (item->errors) CML_TRY(take_values(item->errors, &item->error, err));
    *array = (struct clm_array){.name = field->name,
                                .units = field->units,
                                .meaning = field->long_name,
                                .num_axes = field->num_axes,
                                .count = cml_field_size(field),
                                .single = field->single,
                                .value = item->value,
                                .error = item->error};
    for (int k = 0; k < field->num_axes && k < CLM_MOST_AXES; k++) {
        array->axis[k] = field->axis[k]->name;
        array->size[k] = field->axis[k]->n;
    }
    return CML_OK;
}

CML_API int clm_run_item(struct clm_run *run, int i, struct clm_array *array)
{
    if (i >= 0 && i < run->num_items) return show(&run->item[i], array, &cml_api_error);
    if (run->num_items == 0)
        return cml_fail(&cml_api_error, CML_E_INPUT, "array %d (expected a flight before)", i);
    return cml_fail(&cml_api_error, CML_E_INPUT, "array %d (expected 0 to %d)", i, run->num_items - 1);
}

CML_API int clm_run_array(struct clm_run *run, const char *name, struct clm_array *array)
{
    struct item *item = find_item(run, name);
    if (item) return show(item, array, &cml_api_error);
    return cml_fail(&cml_api_error, CML_E_INPUT, "%s (expected an array of this result)", name);
}

CML_API int clm_run_attribute(struct clm_run *run, int i, const char **name, const char **text,
                              double *number)
{
    if (i < 0 || i >= run->arrays.num_attributes)
        return cml_fail(&cml_api_error, CML_E_INPUT, "attribute %d (expected 0 to %d)", i,
                        run->arrays.num_attributes - 1);
    *name = run->arrays.attribute[i].name;
    *text = run->arrays.attribute[i].value;
    *number = run->arrays.attribute[i].number;
    return CML_OK;
}

CML_API const char *clm_run_json(const struct clm_run *run)
{
    return run->json ? run->json : "";
}

CML_API int clm_run_write(struct clm_run *run, const char *path)
{
    CML_API_CALL();
    if (run->num_items == 0)
        return cml_fail(&cml_api_error, CML_E_INPUT, "%s (expected a flight before)", path);
    struct cml_report report = run->report; /* whose outcome is made anew */
    const cml_status status = cml_report_write(&report, path, &cml_api_error);
    cml_report_clear(&report);
    return status;
}

/* ---- sweeps ---- */

struct sweep {
    struct listener listener; /* first: the address of a sweep is that of its listener */
    clm_row *row;
};

/* Shows the caller a row. */
static cml_status take(void *context, struct cml_report *report, struct cml_error *err)
{
    struct sweep *sweep = context;
    struct clm_run run = {.report = *report};
    cml_status status = view(&run, err);
    if (status == CML_OK && sweep->row(sweep->listener.context, report->row - 1, &run))
        status = cml_fail(err, CML_E_STOPPED, "cancelled in row %d", report->row);
    *report = run.report;
    run.report = (struct cml_report){0};
    clear_view(&run);
    return status;
}

/* The name of the table in messages. */
#define TABLE "the table"

static cml_status fly_sweep(struct clm_scene *scene, const struct cml_options *given, const char *table,
                            struct sweep *sweep, struct cml_error *err)
{
    const struct cml_receiver receiver = {take, on_progress, is_cancelled, on_note, sweep};
    struct cml_options options = *given;
    options.settings = *cml_api_settings(scene, 0);
    options.receiver = &receiver;
    options.sweep = TABLE;
    options.checkpoint_interval = 0;
    options.quiet = true;
    options.command[0] = '\0';
    CML_TRY(cml_check_flight_options(&options, err));
    CML_TRY(cml_sweep_check_options(&options, err));
    struct cml_inputs inputs = {scene->inputs.count + 1,
                                calloc(scene->inputs.count + 1, sizeof *inputs.item)};
    if (!inputs.item) return cml_fail_memory(err, (double)inputs.count * sizeof *inputs.item, "input files");
    memcpy(inputs.item, scene->inputs.item, scene->inputs.count * sizeof *inputs.item);
    inputs.item[scene->inputs.count] =
        (struct cml_input){(char[]){TABLE}, (char *)(uintptr_t)table, strlen(table)};
    const cml_status status = cml_sweep(&options, &scene->list, &inputs, err);
    free(inputs.item);
    return status;
}

CML_API int clm_scene_sweep(struct clm_scene *scene, const char *const *options, const char *table,
                            clm_progress *progress, clm_row *row, void *context)
{
    CML_API_CALL();
    struct sweep sweep = {{progress, context, cml_notes, false}, row};
    struct cml_api_words words;
    struct cml_options parsed;
    cml_status status = cml_api_parse(scene->list.scenes[0].file, &scene->words, options, false, &words,
                                      &parsed, &cml_api_error);
    if (status == CML_OK) status = fly_sweep(scene, &parsed, table, &sweep, &cml_api_error);
    cml_api_words_clear(&words);
    return status;
}
