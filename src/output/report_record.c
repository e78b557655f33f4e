/* Makes the record of a run, which stays when its tallies are gone: a line of JSON, and the numbers for the
 * table of a sweep. SPDX-License-Identifier: MIT */
#include "output/report.h"

#include "base/text.h"

#include <math.h>

/* The numbers that a record holds. Expected values are recorded for all layers, because another row of a
 * sweep may have them for more layers. */
static const struct {
    enum cml_recorded kind;
    enum cml_quantity quantity;
} numbers[] = {
    {CML_RECORDED_TOTALS, CML_QUANTITY_Rsp},
    {CML_RECORDED_TOTALS, CML_QUANTITY_Rd},
    {CML_RECORDED_TOTALS, CML_QUANTITY_A},
    {CML_RECORDED_TOTALS, CML_QUANTITY_Tt},
    {CML_RECORDED_TOTALS, CML_QUANTITY_A_backing},
    {CML_RECORDED_FACE, CML_QUANTITY_A_face},
    {CML_RECORDED_LAYERS, CML_QUANTITY_A_l},
    {CML_RECORDED_BODIES, CML_QUANTITY_A_body},
    {CML_RECORDED_EXPECTED, CML_QUANTITY_Tt_expected},
    {CML_RECORDED_EXPECTED, CML_QUANTITY_A_l_expected},
    {CML_RECORDED_DETECTORS, CML_QUANTITY_detector},
    {CML_RECORDED_FLUXES, CML_QUANTITY_flux_body},
};

/* Adds all numbers and their errors to a record. An error that is not known, such as that of sums over very
 * many facets, is NaN. */
static void record_numbers(const struct cml_outcome *o, struct cml_record *record)
{
    for (size_t n = 0; n < sizeof numbers / sizeof *numbers; n++) {
        const enum cml_quantity quantity = numbers[n].quantity;
        const bool total = cml_quantities[quantity].axis[0] == CML_AXIS_NONE;
        const int beside =
            cml_quantity_is_of_detector(quantity) ? o->num_detectors : o->num_layers + o->num_bodies;
        const double *value = o->value[quantity], *error = o->error[quantity];
        for (size_t i = 0;
             value && (total || beside <= CML_RECORD_MEDIA) && i < cml_outcome_size(o, quantity); i++)
            cml_record_add(record, numbers[n].kind, value[i], error ? error[i] : NAN);
    }
}

/* Makes the short record of a finished run: its numbers, and the line of --json. A sweep shows the record
 * again when it skips a finished row. */
cml_status cml_report_record(const struct cml_report *report, struct cml_record *record,
                             struct cml_error *err)
{
    size_t size = 0;
    *record = (struct cml_record){.photons = report->sums->photons, .lost = cml_result_lost(report->sums)};
    record_numbers(&report->outcome, record);
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
