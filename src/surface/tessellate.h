/* Turns radial heightfields into triangle meshes.
 *
 * Rings: every ring of the heightfield becomes a polygon of N = 8 * 2^k vertices, one of them at azimuth 0;
 * the tip is one vertex. (cml_radial_merge removes needless rings before.) The polygon has the area of its
 * circle: its vertices lie at r sqrt(a / sin a), a = 2 pi / N. The area is therefore preserved everywhere,
 * and the volume exactly between rings of equal N. Strips between rings of different N fan out (drawing in
 * tessellate.c).
 *
 * Bound: the mesh's radius differs from the cone's by at most tolerance * r_last. A vertex takes r (sqrt(a /
 * sin a) - 1) = pi^2 r / (3 N^2) + O(N^-4) of that.
 *
 * Shape: a needle is a triangle whose arc is longer than 16 times the width of its ring.
 *   1. N is the smallest number that keeps the bound.
 *   2. N is raised until no ring makes needles and no strip folds over.
 *   3. A ring beside one over 256 times wider may have arcs of up to the geometric mean of both widths:
 * shorter arcs would make needles of the wide ring's strip.
 *   4. Beyond 4e6 triangles rule 2 allows needles.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"
#include "scene/heightmap/mesh_budget.h"
#include "scene/scene.h"

struct cml_tessellation {
    double tolerance;         /* largest radial deviation as a share of the last radius; default 1e-3 */
    enum cml_normals normals; /* normals of the mesh; default CML_NORMALS_ANALYTIC */
    bool inscribed; /* true: vertices on the circle, the textbook rule, for comparison; false: polygons that
                       preserve the area */
};

/* Makes a prepared mesh (cml_mesh_prepare has run) in the boundary's frame, z = -h(r). radial->n must be at
 * least 2. Returns CML_E_INPUT if the mesh needs more triangles than the budget allows (NULL:
 * CML_MESH_MOST). */
CML_NODISCARD cml_status cml_tessellate(const struct cml_radial *radial,
                                        const struct cml_tessellation *options,
                                        const struct cml_mesh_budget *budget, struct cml_mesh *mesh,
                                        struct cml_error *err);
