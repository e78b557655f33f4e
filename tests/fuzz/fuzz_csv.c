/* .csv files, curves of others: read and drawn. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "plot/plot.h"

enum { MOST_POINTS = 4096 }; /* of a curve that is drawn */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const names[1] = {"a.csv"};
    const struct cml_shown *shown;
    struct cml_curve curve[1][2];
    struct cml_error err = {CML_OK, ""};
    FUZZ_CHECK(cml_shown_find(NULL, &shown, &err) == CML_OK);
    const struct cml_curve_columns columns[2] = {cml_shown_columns(&shown->panel[0]),
                                                 cml_shown_columns(&shown->panel[1])};
    cml_status status = cml_curve_read(fuzz_file(data, size), columns, 2, curve[0], &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return 0;
    }
    FUZZ_CHECK(curve[0][0].n + curve[0][1].n >= 2);
    const struct cml_plot plot = {.shown = shown,
                                  .num_curves = 1,
                                  .curves = curve,
                                  .names = names,
                                  .style = {.x = cml_axis_range_any, .y = cml_axis_range_any}};
    if (curve[0][0].n <= MOST_POINTS) {
        status = cml_plot_script(fuzz_nowhere(), &plot, &err);
        if (status != CML_OK) fuzz_refused(status, &err);
    }
    cml_curve_free(&curve[0][0]);
    cml_curve_free(&curve[0][1]);
    return 0;
}
