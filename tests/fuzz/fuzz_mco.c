/* .mco files: read; written, read and written again with the same bytes; compared with themselves; drawn.
 * SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "plot/compare_report.h"
#include "plot/plot.h"

static const char *const names[2] = {"a.mco", "b.mco"};

/* Equal results have no difference in any test, whatever the numbers. */
static void compare(const struct cml_mco mco[2])
{
    struct cml_comparison comparison;
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_compare(&mco[0], &mco[1], names, &comparison, &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return;
    }
    for (int i = 0; i < comparison.count; i++) FUZZ_CHECK(comparison.test[i].z == 0);
    const struct cml_compare_report report = {
        .names = names, .mco = mco, .comparison = &comparison, .alpha = 0.01};
    FUZZ_CHECK(comparison.p == 1);
    cml_compare_summary(fuzz_nowhere(), &report);
    if (cml_compare_json(fuzz_nowhere(), &report, &err) != CML_OK) fuzz_refused(CML_E_INPUT, &err);
    if (cml_compare_script(fuzz_nowhere(), &report, &err) != CML_OK) fuzz_refused(CML_E_INPUT, &err);
    cml_comparison_clear(&comparison);
}

static void draw(const struct cml_mco mco[2])
{
    struct cml_error err = {CML_OK, ""};
    const struct cml_plot plot = {.count = 2, .num_results = 1, .results = mco, .names = names};
    if (mco->nr < 3) return;
    if (cml_plot_script(fuzz_nowhere(), &plot, &err) != CML_OK) fuzz_refused(CML_E_INPUT, &err);
}

/* The bytes of the file that a result is written as; the caller's to free. */
static char *written(const struct cml_mco *mco, size_t *size)
{
    struct cml_error err = {CML_OK, ""};
    char *bytes = NULL;
    FUZZ_CHECK(cml_mco_write(fuzz_output(), mco, &err) == CML_OK);
    FUZZ_CHECK(cml_text_read_file(fuzz_output(), &bytes, size, &err) == CML_OK);
    return bytes;
}

/* What is read from our own file gives the same bytes. */
static void check_written(struct cml_mco mco[2])
{
    size_t size[2];
    struct cml_error err = {CML_OK, ""};
    char *bytes = written(&mco[0], &size[0]);
    const cml_status status = cml_mco_read(fuzz_output(), &mco[1], &err);
    if (status != CML_OK) fprintf(stderr, "%s\n", err.text);
    FUZZ_CHECK(status == CML_OK);
    char *again = written(&mco[1], &size[1]);
    FUZZ_CHECK(size[0] == size[1] && memcmp(bytes, again, size[0]) == 0);
    free(bytes);
    free(again);
    remove(fuzz_output());
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct cml_mco mco[2];
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_mco_read(fuzz_file(data, size), &mco[0], &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return 0;
    }
    check_written(mco);
    cml_mco_clear(&mco[1]);
    mco[1] = mco[0];
    compare(mco);
    draw(mco);
    cml_mco_clear(&mco[0]);
    return 0;
}
