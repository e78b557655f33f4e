/* What a comparison says: for people, for programs, as a picture of z over every profile.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "plot/compare.h"
#include "plot/gnuplot.h"

struct cml_compare_report {
    const char *const *names;          /* [2] paths, borrowed */
    const struct cml_outcome *outcome; /* [2], borrowed */
    const struct cml_comparison *comparison;
    double alpha; /* level of the verdict */
    enum cml_picture picture;
};

/* Totals, the worst bin of every profile, the worst tests of all, the verdict. */
void cml_compare_summary(FILE *stream, const struct cml_compare_report *report);

/* One object on one line: a b packets tests p alpha agree profiles worst. Keys as documented in README. */
CML_NODISCARD cml_status cml_compare_json(FILE *stream, const struct cml_compare_report *report,
                                          struct cml_error *err);

/* A script for cml_gnuplot_draw: z of every test, one panel per profile, and the limit of the level. `report`
 * is a struct cml_compare_report. */
CML_NODISCARD cml_status cml_compare_script(FILE *out, const void *report, struct cml_error *err);
