/* A mesh prepared for queries: moved to its own middle, with the planes of its facets and its bounds of
 * rounding. SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/footprint.h"
#include "geometry/mesh.h"

/* A mesh in the centred frame: cm, relative to the middle of the mesh's box, axes as in the boundary's frame.
 * Coordinates, and so their rounding, are smallest in this frame. */
struct cml_centred_mesh {
    struct cml_mesh mesh; /* vertices, box and z_border in the centred frame */
    double (*plane)[4];   /* [num_triangles] unit normal, up, and its scalar product with any point of the
                             triangle, cm */
    double centre[3]; /* origin of the centred frame in query coordinates: x and y from the scene's origin,
                         z in the boundary's frame, cm */
    double axis[2];   /* position of the scene's z axis in the centred frame, around which analytic normals
                         are symmetric */
    double lower[3], upper[3];              /* the mesh's box in the centred frame, enlarged by 2 err_float
                                               on each side */
    double err_mesh, err_float, err_margin; /* cm, see rounding.h; err_margin: smallest margin of a ray */
    struct cml_footprint *footprint;        /* owned; NULL for a closed mesh */
};

/* Takes over *mesh, which must be prepared and is left empty, and centres it. x0, y0: scene position where x
 * and y of queries are 0, cm. Returns CML_E_INPUT if memory runs out; cml_centred_mesh_clear then still frees
 * the mesh. */
CML_NODISCARD cml_status cml_centred_mesh_create(struct cml_mesh *mesh, double x0, double y0,
                                                 struct cml_centred_mesh *centred, struct cml_error *err);

/* Frees the mesh's memory and zeroes the structure. */
void cml_centred_mesh_clear(struct cml_centred_mesh *centred);

/* Returns the bytes of the mesh's arrays, without the footprint. */
double cml_centred_mesh_bytes(const struct cml_centred_mesh *centred);

/* Returns corner k (0 to 2) of a triangle, centred frame. */
static inline const double *cml_centred_corner(const struct cml_centred_mesh *centred, int triangle, int k)
{
    return centred->mesh.vertex[centred->mesh.triangle[triangle][k]];
}
