/* clustermcml compare: do two results agree within their noise?
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"
#include "cli/run/outputs.h"

#include "plot/compare_report.h"
#include "plot/files/result_file.h"

/* The picture first: where it fails the exit code says so, and nothing has been claimed yet. */
static cml_status show(const struct cml_options *options, struct cml_compare_report *report,
                       struct cml_error *err)
{
    if (options->output) {
        CML_TRY(cml_gnuplot_draw(cml_compare_script, report, options->output, err));
    }
    if (options->json) return cml_compare_json(stdout, report, err);
    if (!options->quiet) cml_compare_summary(stdout, report);
    return CML_OK;
}

/* A difference is a status of its own and becomes exit code 1, so that scripts can tell it from an error. */
static cml_status verdict(const struct cml_compare_report *report, struct cml_error *err)
{
    const struct cml_comparison *c = report->comparison;
    if (c->count == 0)
        return cml_fail(err, CML_E_INPUT, "%s: too few packets to compare anything with %s", report->names[0],
                        report->names[1]);
    if (!(c->p < report->alpha)) return CML_OK;
    const struct cml_compare_test *worst = &c->test[c->worst];
    return cml_fail(err, CML_E_DIFFER, "%s and %s differ: p = %.3g, worst z = %+.2f in %s", report->names[0],
                    report->names[1], c->p, worst->z, cml_quantities[worst->quantity].name);
}

/* The picture's format is checked before the work, as everything that the user may have mistyped. */
static cml_status compare(const struct cml_options *options, const struct cml_mco mco[2],
                          struct cml_error *err)
{
    const char *const *names = (const char *const *)options->operands;
    struct cml_comparison comparison;
    struct cml_compare_report report = {
        .names = names, .mco = mco, .comparison = &comparison, .alpha = options->alpha};
    if (options->output) CML_TRY(cml_picture_of(options->output, &report.picture, err));
    CML_TRY(cml_compare(&mco[0], &mco[1], names, &comparison, err));
    cml_status status = show(options, &report, err);
    if (status == CML_OK) status = verdict(&report, err);
    cml_comparison_clear(&comparison);
    return status;
}

/* Both are read before anything is said of either. */
cml_status cml_command_compare(const struct cml_options *options, struct cml_error *err)
{
    struct cml_mco mco[2];
    if (options->output) CML_TRY(cml_check_overwrite("compare", options->output, options->operands, 2, err));
    CML_TRY(cml_result_file_read(options->operands[0], &mco[0], err));
    cml_status status = cml_result_file_read(options->operands[1], &mco[1], err);
    if (status == CML_OK) {
        status = compare(options, mco, err);
        cml_mco_clear(&mco[1]);
    }
    cml_mco_clear(&mco[0]);
    return status;
}
