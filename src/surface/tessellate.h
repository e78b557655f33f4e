/* Radial heightfields as triangle meshes.
 * Rings as given (cml_radial_merge drops those that the surface does not need), one vertex at the tip. Every
 * ring is a polygon of 8 * 2^k vertices, one of them at azimuth 0, placed so that it has the area of its
 * circle (r sqrt(a / sin a), a = 2 pi / N): area is preserved everywhere, volume exactly between rings of
 * equal N. Strips between rings of different N fan out. Bound: the mesh's radius differs from the cone's by
 * at most tolerance * r_last; the vertices take r (sqrt(a / sin a) - 1) = pi^2 r / (3 N^2) + O(N^-4) of it.
 * N is the least that keeps the bound, raised so that narrow rings make no needles (no arc beyond 16 ring
 * widths; beside a ring over 256 times wider the arc is the geometric mean of both widths, since a finer one
 * would only move the needles there) and never fold over. Beyond 4e6 triangles the needle rule is relaxed.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"
#include "scene/heightmap/mesh_budget.h"
#include "scene/scene.h"

struct cml_tessellation {
    double tolerance;         /* largest radial deviation as a share of the last radius; 1e-3 by default */
    enum cml_normals normals; /* CML_NORMALS_ANALYTIC by default */
    bool inscribed; /* vertices on the circle instead of area-preserving: the textbook rule, for comparison */
};

/* A prepared mesh (cml_mesh_prepare has run) in the boundary's frame, z = -h(r). radial->n >= 2.
 * CML_E_INPUT when it would need more triangles than the budget (NULL: CML_MESH_MOST) has. */
CML_NODISCARD cml_status cml_tessellate(const struct cml_radial *radial,
                                        const struct cml_tessellation *options,
                                        const struct cml_mesh_budget *budget, struct cml_mesh *mesh,
                                        struct cml_error *err);
