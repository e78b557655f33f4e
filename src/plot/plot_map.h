/* Pictures of maps as scripts for gnuplot: R(x,y) or another array in viridis, maps side by side with the
 * same lengths and colours, so that they can be compared. SPDX-License-Identifier: MIT
 */
#pragma once

#include "plot/plot_parts.h"
#include "plot/files/map_h5.h"

#include <stdbool.h>

/* Names of a map's axes, with their unit, and how it lies. */
struct cml_map_axes {
    const char *name[2];
    bool down;            /* the second axis points down */
    bool free;            /* a centimetre need not be as long on both axes */
    bool round;           /* a disc of 90 degrees; pixels outside are -1 */
    const char *ticks[2]; /* for gnuplot, in place of round numbers; NULL: those */
};
extern const struct cml_map_axes cml_map_xy, cml_map_xz, cml_map_yz, cml_map_rz, cml_map_polar;

struct cml_map_plot {
    int count;
    const struct cml_pixels *maps; /* [count], borrowed */
    const char *const *names;      /* [count], borrowed: above each map */
    const char *quantity;          /* text beside the colour bar, with its unit */
    const char *grey;              /* what a pixel without a colour is: "no light" */
    const struct cml_map_axes *axes;
    enum cml_picture picture;
    struct cml_plot_style style; /* AUTO: log where the light spans more than two decades */
};

/* For cml_gnuplot_draw: writes a script that holds its data and leaves the picture on gnuplot's standard
 * output. `plot` is a struct cml_map_plot. Maps of more than 1000 pixels a side are averaged to fewer.
 * CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_map_script(FILE *out, const void *plot, struct cml_error *err);
