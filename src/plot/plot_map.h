/* Pictures of maps as scripts for gnuplot: R(x,y) or another array in viridis, maps side by side with the
 * same lengths and colours, so that they can be compared. x to the right, y up. SPDX-License-Identifier: MIT
 */
#ifndef CML_PLOT_MAP_H
#define CML_PLOT_MAP_H

#include "plot/plot_parts.h"
#include "plot/vti.h"

struct cml_map_plot {
    int count;
    const struct cml_pixels *maps; /* [count], borrowed */
    const char *const *names;      /* [count], borrowed: paths of the files */
    const char *quantity;          /* text beside the colour bar */
    const char *caption;           /* text below the picture; NULL: none */
    enum cml_picture picture;
    enum cml_scale scale; /* AUTO: log where the light spans more than two decades */
};

/* For cml_gnuplot_draw: writes a script that holds its data and leaves the picture on gnuplot's standard
 * output. `plot` is a struct cml_map_plot. Maps of more than 1000 pixels a side are averaged to fewer.
 * CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_map_script(FILE *out, const void *plot, struct cml_error *err);

#endif
