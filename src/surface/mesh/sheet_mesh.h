/* Cells under a sheet: a mesh whose facets all face up, so that, seen from above, they lie side by side. Each
 * cell of a square grid lists the facets above it, and has their least and greatest depth over the cell. A
 * pyramid of blocks stands above the cells (grid_mesh.h). A grid of lists is the oldest way to find what a
 * ray meets [Fujimoto, Tanaka and Iwata, ARTS: accelerated ray-tracing system, IEEE Computer Graphics and
 * Applications 6 (4), 1986]. SPDX-License-Identifier: MIT */
#pragma once

#include "surface/mesh/grid_mesh.h"

/* Makes the cells of a mesh; the caller clears *grid. *grid has no cells (levels 0) if facets overhang, or if
 * facets differ so much in size or shape that lists would be long. Returns CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_sheet_mesh_find(const struct cml_centred_mesh *centred,
                                             struct cml_grid_mesh *grid, struct cml_error *err);
