/* Mean depths of boundaries, and mean thicknesses of layers between two boundaries, over a level area.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/surface.h"

/* Sets *depth to the mean depth of boundary b in the scene, cm. The mean is taken over a level area (cm2)
 * that contains the whole uneven part of the boundary, or over whole periods of a tile. In a mesh that
 * overhangs, the volume between mesh and plane counts. set: made from the scene with `options`. Returns
 * CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_mean_depth(const struct cml_scene *scene, const struct cml_surface_set *set,
                                        int b, const struct cml_surface_options *options, double area,
                                        double *depth, struct cml_error *err);

/* Mean heights of boundaries and mean thicknesses of layers. */
struct cml_mean_shapes {
    double *height;    /* [L+1] mean height of each boundary above its nominal depth, cm: over the disk of its
                          radius, the footprint of its mesh, or a period of its tile */
    double *area;      /* [L+1] area over which the mean height is taken, cm2; 0 for a plane */
    double *thickness; /* [L] mean thickness of each layer, cm, over the larger area of its two boundaries */
};

/* Computes the means for all boundaries and layers of the scene. The caller frees them with
 * cml_mean_shapes_clear, also after a failure. Returns CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_mean_shapes(const struct cml_scene *scene, const struct cml_surface_set *set,
                                         const struct cml_surface_options *options,
                                         struct cml_mean_shapes *mean, struct cml_error *err);

/* Frees the arrays of means and zeroes the structure. */
void cml_mean_shapes_clear(struct cml_mean_shapes *mean);
