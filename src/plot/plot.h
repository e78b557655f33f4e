/* Pictures of results as scripts for gnuplot: curves over radius, depth or angle, in one panel or two.
 * Results are solid, with a band of their standard error; the n-th curve of others is dashed in the colour of
 * the n-th result, with error bars. Knows the drawing, not the process that draws. SPDX-License-Identifier:
 * MIT
 */
#pragma once

#include "plot/plot_parts.h"
#include "plot/shown.h"

struct cml_plot {
    const struct cml_shown *shown;
    int num_results, num_curves;       /* of others */
    const struct cml_outcome *results; /* [num_results], borrowed */
    const char *const *paths;          /* [num_results], borrowed: of the files, for messages */
    struct cml_curve (*curves)[2];     /* [num_curves] of each panel, borrowed */
    const char *const *names;          /* [num_results + num_curves], borrowed: for the legend */
    const char
        *over; /* NULL; or the curves are of sweeps, and this is their lower axis: they look like results */
    enum cml_picture picture;
    struct cml_plot_style style; /* a log axis unless linear */
};

/* For cml_gnuplot_draw: writes a script that holds its data and leaves the picture on gnuplot's standard
 * output. `plot` is a struct cml_plot. CML_E_INPUT when memory runs out, or a result cannot be shown so. */
CML_NODISCARD cml_status cml_plot_script(FILE *out, const void *plot, struct cml_error *err);
