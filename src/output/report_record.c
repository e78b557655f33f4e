/* What a run leaves behind when its tallies are gone: a line of JSON, and what the table of a sweep has of
 * it. SPDX-License-Identifier: MIT */
#include "output/report.h"

#include "base/text.h"

#include <math.h>

/* Records expected values of all layers: another row of a sweep may expect more of them. */
static void record_expected(const struct cml_result *result, struct cml_record *record)
{
    if (result->grid.scores == 0) return;
    record->num_expected = result->grid.scores > 1 ? 1 + record->num_layers : 1;
    cml_result_expected(result, 0, &record->expected[0], &record->expected_error[0]);
    for (int l = 1; l <= record->num_layers; l++)
        cml_result_expected_layer(result, l, &record->expected[l], &record->expected_error[l]);
}

static void record_detected(const struct cml_result *result, struct cml_record *record)
{
    const int n = result->grid.detectors;
    record->num_detectors = n <= CML_RECORD_MEDIA ? n : 0;
    for (int k = 0; k < record->num_detectors; k++)
        cml_result_detected(result, k, &record->detected[k], &record->detected_error[k]);
}

/* Errors of very many facets are not known. */
static cml_status record_fluxes(const struct cml_report *report, struct cml_record *record,
                                struct cml_error *err)
{
    struct cml_outcome o = {.photons = report->sums->photons, .num_bodies = report->scene->num_bodies};
    const enum cml_quantity flux = CML_QUANTITY_flux_body;
    CML_TRY(cml_report_body_fluxes(report, &o, err));
    if (o.value[flux]) record->num_fluxes = CML_BODY_SIDES * record->num_bodies;
    for (int i = 0; i < record->num_fluxes; i++) {
        record->flux[i] = o.value[flux][i];
        record->flux_error[i] = o.error[flux] ? o.error[flux][i] : NAN;
    }
    cml_outcome_clear(&o);
    return CML_OK;
}

cml_status cml_report_record(const struct cml_report *report, struct cml_record *record,
                             struct cml_error *err)
{
    const struct cml_result *result = report->sums;
    size_t size = 0;
    record->photons = result->photons;
    record->lost = cml_result_lost(result);
    if (result->grid.num_layers + result->grid.num_bodies <= CML_RECORD_MEDIA) {
        record->num_layers = result->grid.num_layers;
        record->num_bodies = result->grid.num_bodies;
    }
    for (int t = 0; t < CML_NUM_TOTALS; t++) {
        record->value[t] = cml_result_total(result, (enum cml_total)t);
        record->error[t] = cml_result_error(result, (enum cml_total)t);
    }
    for (int l = 0; l < record->num_layers + record->num_bodies; l++) {
        const int medium = l < record->num_layers ? l + 1 : l + 2;
        record->absorbed[l] = cml_result_absorbed(result, medium);
        record->absorbed_error[l] = cml_result_absorbed_error(result, medium);
    }
    record_expected(result, record);
    record_detected(result, record);
    CML_TRY(record_fluxes(report, record, err));
    FILE *out = open_memstream(&record->json, &size);
    const cml_status status = out ? cml_report_json(out, report, err) : CML_OK;
    CML_TRY(cml_text_end(out, &record->json, &size, "the JSON record", err));
    return status;
}

cml_status cml_report_record_again(const struct cml_scene *scene, const char *path,
                                   const struct cml_record *before, struct cml_record *record,
                                   struct cml_error *err)
{
    size_t size = 0;
    *record = *before;
    record->json = NULL;
    FILE *out = open_memstream(&record->json, &size);
    const cml_status status = out ? cml_report_json_again(out, before->json, scene, path, err) : CML_OK;
    CML_TRY(cml_text_end(out, &record->json, &size, "the JSON record", err));
    return status;
}
