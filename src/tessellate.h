/* Radial heightfields as triangle meshes.
 * Rings as given; the azimuthal segments of a ring come from the tolerance and double from ring to ring
 * outwards, so that no triangle is a needle; one vertex at the tip. Ring vertices are placed so that the
 * polygon has the area of its circle (r sqrt(h / sin h), h = 2 pi / N), which preserves volume. bound: the
 * mesh's radius differs from the cone's by at most tolerance * r_last (pi^2 r / (3 N^2) per ring)
 * SPDX-License-Identifier: MIT */
#ifndef CML_TESSELLATE_H
#define CML_TESSELLATE_H

#include "mesh.h"
#include "scene.h"

struct cml_tessellation {
    double tolerance;         /* largest radial deviation as a share of the last radius; 1e-3 by default */
    enum cml_normals normals; /* CML_NORMALS_ANALYTIC by default */
    bool inscribed; /* vertices on the circle instead of area-preserving: the textbook rule, for comparison */
};

/* A prepared mesh (cml_mesh_prepare has run) in the boundary's frame, z = -h(r). radial->n >= 2.
 * CML_E_INPUT when it would need more than 2^26 triangles: the message states the number. */
CML_NODISCARD cml_status cml_tessellate(const struct cml_radial *radial,
                                        const struct cml_tessellation *options, struct cml_mesh *mesh,
                                        struct cml_error *err);

#endif
