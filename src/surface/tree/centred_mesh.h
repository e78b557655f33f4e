/* A mesh as its queries want it: centred on the origin, with the planes of its facets, and what rounding can
 * do to it. SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/footprint.h"
#include "geometry/mesh.h"

/* "Centred frame" below: cm, relative to the middle of the mesh's box, axes as in the boundary's frame.
 * Numbers are smallest there, and so is their rounding. */
struct cml_centred_mesh {
    struct cml_mesh mesh; /* vertices, box and z_border in the centred frame */
    double (
        *plane)[4]; /* [num_triangles] unit normal, up, and its product with any point of the triangle, cm */
    double centre[3]; /* the centred frame's origin in query coordinates: x and y from the scene's origin, z
                       * in the boundary's frame, cm */
    double axis[2];   /* centred frame: the scene's z axis, around which analytic normals turn */
    double lower[3], upper[3];              /* centred frame: the box, larger by 2 err_float on each side */
    double err_mesh, err_float, err_margin; /* cm, see rounding.h; err_margin: the least of all rays */
    struct cml_footprint *footprint;        /* owned; NULL of a closed mesh */
};

/* Takes over *mesh (prepared; left empty) and centres it. x0, y0: scene position of the queries' origin, cm.
 * CML_E_INPUT when memory runs out; then it holds what cml_centred_mesh_clear frees. */
CML_NODISCARD cml_status cml_centred_mesh_create(struct cml_mesh *mesh, double x0, double y0,
                                                 struct cml_centred_mesh *centred, struct cml_error *err);
void cml_centred_mesh_clear(struct cml_centred_mesh *centred);

/* Memory of its arrays but the footprint's. */
double cml_centred_mesh_bytes(const struct cml_centred_mesh *centred);

/* Corner k (0 to 2) of a triangle, centred frame. */
static inline const double *cml_centred_corner(const struct cml_centred_mesh *centred, int triangle, int k)
{
    return centred->mesh.vertex[centred->mesh.triangle[triangle][k]];
}
