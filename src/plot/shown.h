/* What `plot --of` can show of a result: curves over r, z or the angle, and maps over (r, z) or directions.
 * Fluence without a fluence line is absorbed weight per volume over the absorption coefficient of the layer
 * (MCML manual, eqs 4.27 and 4.28), per launched packet: [-] over z, 1/cm2 over (r, z). A bin that two media
 * share has none. SPDX-License-Identifier: MIT */
#pragma once

#include "plot/files/curve.h"
#include "plot/files/map_h5.h"
#include "result/outcome.h"

/* What becomes of a value before it is drawn; of a map its standard error may stand in its place. */
enum cml_shown_as { CML_SHOWN_PLAIN, CML_SHOWN_ERROR, CML_SHOWN_TIMES_R, CML_SHOWN_OVER_MUA };

struct cml_shown_panel {
    enum cml_quantity quantity;
    enum cml_shown_as as;
    const char *title, *axis; /* above the panel; beside its values, with their unit */
    const char *detector;     /* "detector_NAME_t", whose gates they are; NULL: of no detector */
};

struct cml_shown {
    const char *name;
    int num_panels; /* 1 or 2, one above the other with a common axis; 0: a map */
    struct cml_shown_panel panel[2];
    const char *map; /* beside its colours, with their unit; NULL: curves */
    bool polar;      /* a map over directions: the angle from the middle on, the azimuth around it */
};

/* The names of gates of a detector, detector_NAME_t, are all of one entry, for the caller to fill in which.
 * NULL: what is shown without being asked, r Rd(r) and r Tt(r). CML_E_INPUT with all names. */
CML_NODISCARD cml_status cml_shown_find(const char *name, const struct cml_shown **shown,
                                        struct cml_error *err);

/* All names, with commas. */
enum { CML_SHOWN_NAMES = 256 };
void cml_shown_names(char names[CML_SHOWN_NAMES]);

/* The axis under a panel: "radius r [cm]". */
const char *cml_shown_axis(const struct cml_shown_panel *panel);

/* How the columns of a panel's curves of others are called. */
struct cml_curve_columns cml_shown_columns(const struct cml_shown_panel *panel);

/* A result's curve at the middles of its bins, with its errors where the file has them. The last bin over r
 * and z is left out. A fluence where nothing absorbs, or two media share the bin, is a gap. The caller frees
 * it. CML_E_INPUT names `path` where a fluence is asked for and no layer absorbs, or the file does not say
 * where its shapes lie. */
CML_NODISCARD cml_status cml_shown_curve(const struct cml_outcome *outcome, const char *path,
                                         const struct cml_shown_panel *panel, struct cml_curve *curve,
                                         struct cml_error *err);

/* A curve of others as the panel shows it: their values are the quantity's, without what becomes of it. */
CML_NODISCARD cml_status cml_shown_curve_of_others(const struct cml_curve *from,
                                                   const struct cml_shown_panel *panel,
                                                   struct cml_curve *curve, struct cml_error *err);

/* A map over (r, z), z from above, without the last bins; NAN where a fluence is asked for and has a gap. Or
 * one over directions, in degrees; -1 beyond 90. The caller clears it. CML_E_INPUT as above, and when there
 * are fewer than 2 bins, or no directions. */
CML_NODISCARD cml_status cml_shown_map(const struct cml_outcome *outcome, const char *path,
                                       const struct cml_shown *shown, struct cml_pixels *map,
                                       struct cml_error *err);
