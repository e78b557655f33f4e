/* clustermcml compare: do two results agree within their noise?
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"
#include "cli/run/outputs.h"

#include "plot/compare_report.h"
#include "result/h5.h"

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
    if (!(c->p < report->alpha)) return CML_OK;
    const struct cml_compare_test *worst = &c->test[c->worst];
    return cml_fail(err, CML_E_DIFFER, "%s and %s differ: p = %.3g, worst z = %+.2f in %s", report->names[0],
                    report->names[1], c->p, worst->z, worst->key);
}

/* Nothing is said of results that cannot be compared. */
static cml_status check_tests(const struct cml_compare_report *report, struct cml_error *err)
{
    if (report->comparison->tests > 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "compare: %s and %s: %g and %g packets (expected enough to compare anything)",
                    report->names[0], report->names[1], (double)report->outcome[0].photons,
                    (double)report->outcome[1].photons);
}

/* The picture's format is checked before the work, as everything that the user may have mistyped. */
static cml_status compare(const struct cml_options *options, const struct cml_outcome outcome[2],
                          struct cml_error *err)
{
    const char *const *names = (const char *const *)options->operands;
    CML_AT_END(cml_comparison_clear) struct cml_comparison comparison = {0};
    struct cml_compare_report report = {
        .names = names, .outcome = outcome, .comparison = &comparison, .alpha = options->alpha};
    if (options->output) CML_TRY(cml_picture_of(options->output, &report.picture, err));
    CML_TRY(cml_compare(&outcome[0], &outcome[1], names, &comparison, err));
    CML_TRY(check_tests(&report, err));
    CML_TRY(show(options, &report, err));
    return verdict(&report, err);
}

/* The command `compare`. Both results are read before anything is said of either. */
cml_status cml_command_compare(const struct cml_options *options, struct cml_error *err)
{
    struct cml_outcome outcome[2];
    if (options->output) CML_TRY(cml_check_overwrite("compare", options->output, options->operands, 2, err));
    CML_TRY(cml_result_read(options->operands[0], &outcome[0], err));
    cml_status status = cml_result_read(options->operands[1], &outcome[1], err);
    if (status == CML_OK) {
        for (int i = 0; i < 2 && status == CML_OK; i++)
            status = cml_outcome_check(&outcome[i], options->operands[i], err);
        if (status == CML_OK) status = compare(options, outcome, err);
        cml_outcome_clear(&outcome[1]);
    }
    cml_outcome_clear(&outcome[0]);
    return status;
}
