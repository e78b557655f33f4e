/* Mean depths of boundaries: what lies between two of them over a level area. SPDX-License-Identifier: MIT */
#pragma once

#include "surface/surface.h"

/* *depth: the scene's, cm, mean over a level area (cm2) that holds all that is not level of boundary b, or
 * whole periods of a tile; of a sheet that overhangs the volume between it and a level plane counts. set:
 * made of the scene with `options`. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_mean_depth(const struct cml_scene *scene, const struct cml_surface_set *set,
                                        int b, const struct cml_surface_options *options, double area,
                                        double *depth, struct cml_error *err);

/* What boundaries and layers are in the mean. */
struct cml_mean_shapes {
    double *height; /* [L+1] of a boundary above its nominal depth, cm: over its radius, the footprint of its
                     * mesh, a period of its tile */
    double *area;   /* [L+1] cm2, of that; 0: a plane */
    double *thickness; /* [L] of a layer, cm: over the larger of its boundaries' areas */
};

/* Free it with cml_mean_shapes_clear, also after a failure. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_mean_shapes(const struct cml_scene *scene, const struct cml_surface_set *set,
                                         const struct cml_surface_options *options,
                                         struct cml_mean_shapes *mean, struct cml_error *err);
void cml_mean_shapes_clear(struct cml_mean_shapes *mean);
