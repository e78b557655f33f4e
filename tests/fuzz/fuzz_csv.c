/* .csv files, curves of others: read and drawn. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "plot/curve.h"
#include "plot/plot.h"

enum { MOST_BINS = 4096 }; /* of a curve that is drawn */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const names[1] = {"a.csv"};
    struct cml_mco curve;
    struct cml_error err = {CML_OK, ""};
    cml_status status = cml_curve_read(fuzz_file(data, size), &curve, &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return 0;
    }
    FUZZ_CHECK(curve.nr >= 2 && curve.nr <= 1000000 && curve.dr >= 0);
    const struct cml_plot plot = {.count = 1, .results = &curve, .names = names};
    if (curve.nr >= 3 && curve.nr <= MOST_BINS) {
        status = cml_plot_script(fuzz_nowhere(), &plot, &err);
        if (status != CML_OK) fuzz_refused(status, &err);
    }
    cml_mco_clear(&curve);
    return 0;
}
