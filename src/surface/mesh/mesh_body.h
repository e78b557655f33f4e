/* A mesh as its queries want it: centred on the origin, with the planes of its facets.
 * SPDX-License-Identifier: MIT */
#ifndef CML_MESH_BODY_H
#define CML_MESH_BODY_H

#include "geometry/footprint.h"
#include "geometry/mesh.h"

struct cml_mesh_body {
    struct cml_mesh mesh; /* vertices relative to centre */
    double (*plane)[4]; /* [num_triangles] unit normal, up, and its product with any point of the triangle */
    double centre[3];   /* in query coordinates: x and y from the beam's axis, z in the boundary's frame */
    double axis[2];     /* the scene's z axis relative to centre: where an analytic normal is centred */
    double lower[3], upper[3]; /* box, inflated, relative to centre */
    double digits;             /* more than rounding in double can move a point of the mesh */
    double inflation;          /* how much every box grows: more than the rounding of ray and box to float */
    struct cml_footprint *footprint;
};

/* Takes over *mesh (prepared; left empty) and centres it. x0, y0: scene position of the queries' origin. On
 * failure the body holds what cml_mesh_body_clear frees. */
CML_NODISCARD cml_status cml_mesh_body_create(struct cml_mesh *mesh, double x0, double y0,
                                              struct cml_mesh_body *body, struct cml_error *err);
void cml_mesh_body_clear(struct cml_mesh_body *body);

#endif
