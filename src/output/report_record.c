/* What a run leaves behind when its tallies are gone: a line of JSON, and what the table of a sweep has of
 * it. SPDX-License-Identifier: MIT */
#include "output/report.h"

#include "base/text.h"

#include <math.h>

/* Expected values of all layers: another row of a sweep may expect more of them. */
static void record_expected(const struct cml_result *result, int layers, struct cml_record *record)
{
    double value, error;
    for (int l = 0; l <= (result->grid.scores > 1 ? layers : result->grid.scores - 1); l++) {
        if (l == 0)
            cml_result_expected(result, 0, &value, &error);
        else
            cml_result_expected_layer(result, l, &value, &error);
        cml_record_add(record, CML_RECORDED_EXPECTED, value, error);
    }
}

/* Errors of very many facets are not known. */
static cml_status record_fluxes(const struct cml_report *report, int bodies, struct cml_record *record,
                                struct cml_error *err)
{
    struct cml_outcome o = {.photons = report->sums->photons, .num_bodies = report->scene->num_bodies};
    const enum cml_quantity flux = CML_QUANTITY_flux_body;
    CML_TRY(cml_report_body_fluxes(report, &o, err));
    for (int i = 0; o.value[flux] && i < CML_BODY_SIDES * bodies; i++)
        cml_record_add(record, CML_RECORDED_FLUXES, o.value[flux][i], o.error[flux] ? o.error[flux][i] : NAN);
    cml_outcome_clear(&o);
    return CML_OK;
}

/* What a medium absorbs. */
static void record_absorbed(const struct cml_result *result, enum cml_recorded kind, int medium,
                            struct cml_record *record)
{
    cml_record_add(record, kind, cml_result_absorbed(result, medium),
                   cml_result_absorbed_error(result, medium));
}

cml_status cml_report_record(const struct cml_report *report, struct cml_record *record,
                             struct cml_error *err)
{
    const struct cml_result *result = report->sums;
    const struct cml_tally_grid *grid = &result->grid;
    const bool few = grid->num_layers + grid->num_bodies <= CML_RECORD_MEDIA;
    const int layers = few ? grid->num_layers : 0, bodies = few ? grid->num_bodies : 0,
              totals = cml_num_totals(report->scene->backing.kind != CML_BACKING_NONE);
    size_t size = 0;
    *record = (struct cml_record){.photons = result->photons, .lost = cml_result_lost(result)};
    for (int t = 0; t < totals; t++)
        cml_record_add(record, CML_RECORDED_TOTALS, cml_result_total(result, (enum cml_total)t),
                       cml_result_error(result, (enum cml_total)t));
    for (int l = 1; l <= layers; l++) record_absorbed(result, CML_RECORDED_LAYERS, l, record);
    for (int k = 0; k < bodies; k++) record_absorbed(result, CML_RECORDED_BODIES, layers + 2 + k, record);
    record_expected(result, layers, record);
    for (int k = 0; grid->detectors <= CML_RECORD_MEDIA && k < grid->detectors; k++) {
        double value, error;
        cml_result_detected(result, k, &value, &error);
        cml_record_add(record, CML_RECORDED_DETECTORS, value, error);
    }
    CML_TRY(record_fluxes(report, bodies, record, err));
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
