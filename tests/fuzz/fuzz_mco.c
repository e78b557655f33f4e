/* .mco files: read; written, read and written again with the same bytes; compared with themselves; drawn.
 * SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "plot/compare_report.h"
#include "plot/plot.h"
#include "plot/plot_map.h"
#include "result/mco.h"

static const char *const names[2] = {"a.mco", "b.mco"};

/* Equal results have no difference in any test, whatever the numbers. */
static void compare(const struct cml_outcome mco[2])
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
        .names = names, .outcome = mco, .comparison = &comparison, .alpha = 0.01};
    FUZZ_CHECK(comparison.p == 1);
    cml_compare_summary(fuzz_nowhere(), &report);
    if (cml_compare_json(fuzz_nowhere(), &report, &err) != CML_OK) fuzz_refused(CML_E_INPUT, &err);
    if (cml_compare_script(fuzz_nowhere(), &report, &err) != CML_OK) fuzz_refused(CML_E_INPUT, &err);
    cml_comparison_clear(&comparison);
}

/* Everything that can be shown of it, as curves or as a map over (r, z). */
static void draw(const struct cml_outcome mco[2])
{
    static const char *const of[] = {NULL, "Rd_r", "Tt_a", "fluence", "A_rz", "fluence_rz"};
    const struct cml_plot_style style = {
        .x = cml_axis_range_any, .y = cml_axis_range_any, .colour = cml_axis_range_any, .percentile = 90};
    const struct cml_shown *shown;
    struct cml_error err = {CML_OK, ""};
    if (mco->nr < 3) return;
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        FUZZ_CHECK(cml_shown_find(of[i], &shown, &err) == CML_OK);
        struct cml_pixels map = {0};
        const struct cml_plot plot = {
            .shown = shown, .num_results = 2, .results = mco, .paths = names, .names = names, .style = style};
        const struct cml_map_plot picture = {.count = 1,
                                             .maps = &map,
                                             .names = names,
                                             .quantity = "A",
                                             .grey = "no light",
                                             .axes = &cml_map_rz,
                                             .style = style};
        cml_status status = shown->map ? cml_shown_map(mco, names[0], shown, &map, &err)
                                       : cml_plot_script(fuzz_nowhere(), &plot, &err);
        if (status == CML_OK && map.value && map.n[0] * map.n[1] < 4096)
            status = cml_map_script(fuzz_nowhere(), &picture, &err);
        if (status != CML_OK) fuzz_refused(status, &err);
        cml_pixels_clear(&map);
    }
}

/* The bytes of the file that a result is written as; the caller's to free. */
static char *written(const struct cml_outcome *mco, size_t *size)
{
    struct cml_error err = {CML_OK, ""};
    char *bytes = NULL;
    FUZZ_CHECK(cml_mco_write(fuzz_output(), mco, &err) == CML_OK);
    FUZZ_CHECK(cml_text_read_file(fuzz_output(), SIZE_MAX, &bytes, size, &err) == CML_OK);
    return bytes;
}

/* What is read from our own file gives the same bytes. */
static void check_written(struct cml_outcome mco[2])
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
    struct cml_outcome mco[2];
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_mco_read(fuzz_file(data, size), &mco[0], &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return 0;
    }
    check_written(mco);
    cml_outcome_clear(&mco[1]);
    mco[1] = mco[0];
    compare(mco);
    draw(mco);
    cml_outcome_clear(&mco[0]);
    return 0;
}
