/* Pictures of results as scripts for gnuplot: r*Rd(r) and r*Tt(r) over r.
 * Results are solid, with a band of their standard error; the n-th curve is dashed in the colour of the n-th
 * result. Knows the drawing, not the process that draws. SPDX-License-Identifier: MIT */
#ifndef CML_PLOT_H
#define CML_PLOT_H

#include "output/mco.h"
#include "plot/plot_parts.h"

struct cml_plot {
    int count; /* of results and, behind them, curves of others (curve.h) */
    int num_results;
    const struct cml_mco *results; /* [count], borrowed, nr >= 3 each */
    const char *const *names;      /* [count], borrowed: paths of the files, for the legend */
    const char *caption;           /* text below the picture; NULL: none */
    enum cml_picture picture;
    enum cml_scale scale; /* of the curves; log unless linear */
};

/* For cml_gnuplot_draw: writes a script that holds its data and leaves the picture on gnuplot's standard
 * output. `plot` is a struct cml_plot. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_plot_script(FILE *out, const void *plot, struct cml_error *err);

#endif
