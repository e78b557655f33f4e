/* The question that the walk asks the host about a triangle mesh: where does a path cross it? The host puts a
 * function that answers it into struct cml_world (src/surface/mesh/mesh_surface.h). Not for OpenCL: devices
 * refuse meshes.
 * SPDX-License-Identifier: MIT */
#pragma once

/* on_primitive of a packet that has interacted within rounding of a mesh: it stands on no facet, and may be
 * beyond one. */
#define CML_NEAR_FACETS (-2)
/* on_primitive of a packet that stands on nothing and is further from all facets than rounding could put
 * it. */
#define CML_OFF_FACETS (-3)

#ifndef __OPENCL_VERSION__

/* P5: a packet is at the bottom of a groove if it came from the facet before by less than this share of the
 * shortest height of the facet that it meets. */
#define CML_GROOVE_SHARE 0.0009765625

struct cml_mesh_surface;

/* Number of the outer plane among the primitives of a mesh. All other primitives are its triangles. */
#define CML_OUTER_PLANE 0x7fffffff

struct cml_mesh_crossing {
    double t;         /* distance, cm */
    double point[3];  /* in the boundary's frame, x and y from the scene's origin, cm */
    double normal[3]; /* unit, up: the normal for Fresnel's and Snell's laws; in a groove the facet's */
    double facet[3];  /* unit, up: the facet's own normal */
    int primitive;    /* number of the triangle, or CML_OUTER_PLANE */
    /* Filled without a crossing too: 1 if the path was searched as a whole line and ends within rounding of a
     * facet; CML_PATH_TOO_LONG if it was not followed to its end. */
    int ends_near_facet;
};

/* The path crosses too many periods of a repeated mesh. */
#define CML_PATH_TOO_LONG 2

/* Finds the closest crossing of a ray with a mesh and its outer plane. Returns 1 and fills *crossing if there
 * is one with t < t_max. ends_near_facet is always filled.
 * p: in the boundary's frame, from the scene's origin, cm. u: unit direction. below: the packet is below the
 * boundary. t_max: length of the path, cm. exclude: the primitive that the packet stands on, -1,
 * CML_NEAR_FACETS or CML_OFF_FACETS. undeflected: the packet came through that primitive undeflected, so
 * everything behind the primitive on the same line has been dealt with.
 * err_position, cm: a crossing up to this distance behind p counts as one at p, because rounding has put the
 * packet beyond a facet that it has not crossed. exact: 1 tests all candidates in double precision; 0 finds
 * the hit in the fastest way, and computes only the hit in double. */
typedef int cml_mesh_intersect(const struct cml_mesh_surface *mesh, const double p[3], const double u[3],
                               int below, double t_max, int exclude, int undeflected, int exact,
                               double err_position, struct cml_mesh_crossing *crossing);

#endif
