/* SPDX-License-Identifier: MIT */
#include "output/study/merge_parts.h"

#include "base/json_name.h"
#include "base/text.h"
#include "base/version.h"
#include "result/h5.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- means ---- */

/* What all results have. */
static bool all_have(const struct cml_merge_input *inputs, int count, enum cml_quantity quantity, bool errors)
{
    for (int k = 0; k < count; k++) {
        const struct cml_outcome *o = inputs[k].outcome;
        if (!(errors ? o->error : o->value)[quantity]) return false;
    }
    return true;
}

/* Numbers of the scene are alike in all; counts are sums; all else are means over packets. */
static cml_status merge_values(const struct cml_merge_input *inputs, int count, enum cml_quantity quantity,
                               struct cml_outcome *merged, struct cml_error *err)
{
    const enum cml_estimator estimator = cml_quantities[quantity].estimator;
    const bool sums = estimator >= CML_FROM_COUNT && estimator <= CML_FROM_LOST;
    const size_t size = cml_outcome_size(merged, quantity);
    CML_TRY(cml_outcome_add(merged, quantity, false, err));
    double *to = merged->value[quantity];
    for (int k = 0; k < (estimator == CML_FROM_INPUT ? 1 : count); k++) {
        const double share = (double)inputs[k].outcome->photons / (double)merged->photons;
        const double weight = sums || estimator == CML_FROM_INPUT ? 1 : share;
        for (size_t i = 0; i < size; i++) to[i] += weight * inputs[k].outcome->value[quantity][i];
    }
    return CML_OK;
}

/* Roots of sums of squares. */
static cml_status merge_errors(const struct cml_merge_input *inputs, int count, enum cml_quantity quantity,
                               struct cml_outcome *merged, struct cml_error *err)
{
    const size_t size = cml_outcome_size(merged, quantity);
    CML_TRY(cml_outcome_add(merged, quantity, true, err));
    double *to = merged->error[quantity];
    for (int k = 0; k < count; k++) {
        const double weight = cml_merge_error_weight(inputs, count, k),
                     *of = inputs[k].outcome->error[quantity];
        for (size_t i = 0; weight > 0 && i < size; i++) to[i] += weight * of[i] * weight * of[i];
        if (merged->photons == (uint64_t)count)
            cml_merge_add_spread(to, inputs[k].outcome->value[quantity], merged->value[quantity], size,
                                 count);
    }
    for (size_t i = 0; i < size; i++) to[i] = sqrt(to[i]);
    return CML_OK;
}

/* Means of detectors count by the light that each result has detected, and what has detected nothing not at
 * all. */
static cml_status merge_means(const struct cml_merge_input *inputs, int count, enum cml_quantity quantity,
                              struct cml_outcome *merged, struct cml_error *err)
{
    const size_t size = cml_outcome_size(merged, quantity), part = cml_outcome_part_size(merged, quantity);
    CML_TRY(cml_outcome_add(merged, quantity, false, err));
    CML_TRY(cml_outcome_add(merged, quantity, true, err));
    for (size_t i = 0; i < size; i++) {
        double all = 0, mean = 0, squares = 0;
        for (int k = 0; k < count; k++) {
            const struct cml_outcome *o = inputs[k].outcome;
            const double light = (double)o->photons * o->value[CML_QUANTITY_detector][i / part],
                         error = light * o->error[quantity][i];
            if (!(light > 0)) continue;
            all += light;
            mean += light * o->value[quantity][i];
            squares += error * error;
        }
        merged->value[quantity][i] = all > 0 ? mean / all : NAN;
        merged->error[quantity][i] = all > 0 ? sqrt(squares) / all : NAN;
    }
    return CML_OK;
}

static cml_status merge_quantities(const struct cml_merge_input *inputs, int count,
                                   struct cml_outcome *merged, struct cml_error *err)
{
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        const enum cml_quantity quantity = (enum cml_quantity)i;
        if (cml_quantities[i].estimator == CML_FROM_MEANS) {
            if (all_have(inputs, count, quantity, false) && all_have(inputs, count, quantity, true) &&
                all_have(inputs, count, CML_QUANTITY_detector, false))
                CML_TRY(merge_means(inputs, count, quantity, merged, err));
            continue;
        }
        if (all_have(inputs, count, quantity, false))
            CML_TRY(merge_values(inputs, count, quantity, merged, err));
        if (all_have(inputs, count, quantity, true))
            CML_TRY(merge_errors(inputs, count, quantity, merged, err));
    }
    return CML_OK;
}

/* ---- what no run writes ---- */

static cml_status check_errors(const struct cml_merge_input *input, struct cml_error *err)
{
    if (input->outcome->error[CML_QUANTITY_Rsp] && input->outcome->num_streams > 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "%.200s: has no seed or no standard errors (expected a result of this program)",
                    input->name);
}

/* ---- what is not counted ---- */

/* What all share is that of the first; of evenly spread draws one is enough. */
static void merge_provenance(const struct cml_merge_input *inputs, int count, struct cml_outcome *merged)
{
    double *value = merged->provenance.value;
    for (int i = 0; i < CML_NUM_OPTIONS_OF_BITS; i++)
        if (cml_options_of_bits[i].apart) value[i] = inputs[0].outcome->provenance.value[i] != 0;
    value[CML_DECIDES_sampling] = 0;
    for (int k = 0; k < count; k++)
        if (inputs[k].outcome->provenance.value[CML_DECIDES_sampling] > 0) value[CML_DECIDES_sampling] = 1;
}

cml_status cml_merge_head(const struct cml_merge_input *inputs, int count, const char *title,
                          struct cml_outcome *merged, struct cml_error *err)
{
    const struct cml_outcome *first = inputs[0].outcome;
    *merged = (struct cml_outcome){.dz = first->dz,
                                   .dr = first->dr,
                                   .nz = first->nz,
                                   .nr = first->nr,
                                   .na = first->na,
                                   .time_end = first->time_end,
                                   .num_gates = first->num_gates,
                                   .nt = first->nt,
                                   .np = first->np,
                                   .num_layers = first->num_layers,
                                   .num_bodies = first->num_bodies,
                                   .merged = true,
                                   .provenance = cml_provenance_unknown()};
    for (int k = 0; k < count; k++) {
        const struct cml_outcome *o = inputs[k].outcome;
        if (!(merged->n_above > 0)) merged->n_above = o->n_above;
        if (!(merged->n_below > 0)) merged->n_below = o->n_below;
        merged->photons += o->photons;
        merged->user_time += o->user_time;
        for (int i = 0; i < o->num_streams; i++)
            CML_TRY(cml_outcome_add_stream(merged, inputs[k].name, o->stream[i].seed, o->stream[i].run, err));
    }
    merge_provenance(inputs, count, merged);
    CML_TRY(cml_text_copy(title, &merged->output, err));
    CML_TRY(cml_text_copy(cml_version(), &merged->program, err));
    return cml_merge_words(inputs[0].outcome, merged, err);
}

static cml_status fill(const struct cml_merge_input *inputs, int count, const char *title,
                       struct cml_outcome *merged, struct cml_error *err)
{
    for (int k = 0; k < count; k++) CML_TRY(cml_outcome_check(inputs[k].outcome, inputs[k].name, err));
    CML_TRY(cml_merge_head(inputs, count, title, merged, err));
    CML_TRY(cml_outcome_allocate(merged, err));
    for (int i = 0; i < inputs[0].outcome->num_heights; i++) {
        const struct cml_heights *of = &inputs[0].outcome->heights[i];
        double *pair;
        CML_TRY(cml_outcome_add_heights(merged, of->boundary, of->n, &pair, err));
        memcpy(pair, of->pair, 2 * (size_t)of->n * sizeof *pair);
    }
    return merge_quantities(inputs, count, merged, err);
}

cml_status cml_merge(const struct cml_merge_input *inputs, int count, const char *title,
                     struct cml_outcome *merged, struct cml_error *err)
{
    *merged = (struct cml_outcome){0};
    for (int k = 0; k < count; k++) CML_TRY(check_errors(&inputs[k], err));
    CML_TRY(cml_merge_check(inputs, count, err));
    const cml_status status = fill(inputs, count, title, merged, err);
    if (status != CML_OK) cml_outcome_clear(merged);
    return status;
}

static bool any_has(const struct cml_merge_input *inputs, int count, int quantity)
{
    for (int k = 0; k < count; k++)
        if (inputs[k].outcome->value[quantity]) return true;
    return false;
}

cml_status cml_merge_left_out(const struct cml_merge_input *inputs, int count,
                              const struct cml_outcome *merged, char **names, struct cml_error *err)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    for (int i = 0; out && i < CML_NUM_QUANTITIES; i++)
        if (!merged->value[i] && any_has(inputs, count, i))
            fprintf(out, "%s%s", ftell(out) > 0 ? ", " : "", cml_quantities[i].name);
    CML_TRY(cml_text_end(out, &text, &size, "names", err));
    *names = size > 0 ? text : NULL;
    if (size == 0) free(text);
    return CML_OK;
}

/* ---- files ---- */

cml_status cml_merge_write_h5(const char *path, const struct cml_outcome *merged,
                              const struct cml_merge_input *inputs, int count,
                              const struct cml_hdf5_call *call, struct cml_error *err)
{
    struct cml_merge_arrays arrays;
    CML_TRY(cml_merge_arrays_open(inputs, count, merged, &arrays, err));
    const struct cml_h5_more more = {.field = arrays.field, .num_fields = arrays.count, .call = *call};
    cml_status status = cml_h5_write(path, merged, &more, err);
    if (arrays.broken) {
        *err = arrays.err;
        status = err->status;
    }
    cml_merge_arrays_close(&arrays);
    return status;
}

int cml_merged_totals(const struct cml_outcome *merged)
{
    return cml_num_totals(merged->value[CML_QUANTITY_A_backing] && merged->error[CML_QUANTITY_A_backing]);
}

static json_t *json_of(const char *path, const struct cml_merge_input *inputs, int count,
                       const struct cml_outcome *merged)
{
    json_t *names = json_array();
    for (int k = 0; k < count; k++) json_array_append_new(names, cml_json_name(inputs[k].name));
    return json_pack("{s:o, s:o, s:I}", "output", cml_json_name(path), "inputs", names, "photons",
                     (json_int_t)merged->photons);
}

cml_status cml_merge_saved_json(FILE *stream, const char *path, const struct cml_merge_input *inputs,
                                int count, const struct cml_outcome *merged,
                                const struct cml_merge_saved *saved, struct cml_error *err)
{
    json_t *object = json_of(path, inputs, count, merged);
    json_object_update_new(object, json_pack("{s:I, s:I, s:I, s:s}", "rows", (json_int_t)saved->rows, "found",
                                             (json_int_t)saved->found, "covers", (json_int_t)saved->covers,
                                             "version", cml_version()));
    return cml_json_print(stream, object, err);
}

cml_status cml_merge_json(FILE *stream, const char *path, const struct cml_merge_input *inputs, int count,
                          const struct cml_outcome *merged, struct cml_error *err)
{
    json_t *object = json_of(path, inputs, count, merged);
    for (int errors = 0; errors < 2; errors++)
        for (int i = 0; i < cml_merged_totals(merged); i++) {
            const enum cml_quantity total = cml_quantity_of_total(i);
            char key[16];
            snprintf(key, sizeof key, "%s%s", cml_quantities[total].name, errors ? "_se" : "");
            json_object_set_new(object, key, json_real((errors ? merged->error : merged->value)[total][0]));
        }
    json_object_set_new(object, "version", json_string(cml_version()));
    return cml_json_print(stream, object, err);
}
