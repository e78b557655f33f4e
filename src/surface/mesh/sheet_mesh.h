/* Cells under a mesh that is a single sheet: all its facets face up, so that, seen from
 * above, they lie side by side. Every cell of a square grid lists the facets above it, and has their least
 * and greatest depth there; above the cells stands a pyramid (grid_mesh.h). A grid of
 * lists is the oldest way to find what a ray meets [Fujimoto, Tanaka and Iwata, ARTS: accelerated ray-tracing
 * system, IEEE Computer Graphics and Applications 6 (4), 1986]. SPDX-License-Identifier: MIT */
#pragma once

#include "surface/mesh/grid_mesh.h"

/* *grid owns its cells; none (levels 0) when facets overhang, or when their sizes or shapes differ so much
 * that lists would be long. CML_E_INPUT for memory. */
CML_NODISCARD cml_status cml_sheet_mesh_find(const struct cml_centred_mesh *centred,
                                             struct cml_grid_mesh *grid, struct cml_error *err);
