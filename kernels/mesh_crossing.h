/* Where a packet meets a triangle mesh: what the walk asks the host for. The walk does not know how it is
 * found; the host puts a function into struct cml_world that does (src/surface/mesh/mesh_surface.h). Not for
 * OpenCL: devices refuse meshes. SPDX-License-Identifier: MIT */
#pragma once

/* on_primitive of a packet that has interacted within rounding of a mesh: it stands on no facet, and may be
 * beyond one. */
#define CML_NEAR_FACETS (-2)
/* of one that stands on nothing, and that all facets are further from than rounding could put it */
#define CML_OFF_FACETS (-3)

#ifndef __OPENCL_VERSION__

/* P5: of the shortest height of the facet that a packet meets: how far it may have come from the facet before
 * to be in the bottom of a groove. */
#define CML_GROOVE_SHARE 0.0009765625

struct cml_mesh_surface;

/* Number of the outer plane among the primitives of a mesh; the others are its triangles. */
#define CML_OUTER_PLANE 0x7fffffff

struct cml_mesh_crossing {
    double t;            /* distance, cm */
    double point[3];     /* in the boundary's frame, x and y from the scene's origin, cm */
    double normal[3];    /* unit, up: what Fresnel and Snell see; in a groove the facet's */
    double facet[3];     /* unit, up: the facet's own */
    int primitive;       /* triangle, or CML_OUTER_PLANE */
    int ends_near_facet; /* without a crossing: 1 where the path was looked at as a whole line, and ends
                          * within rounding of a facet; CML_PATH_TOO_LONG where it was not followed to its end
                          */
};

/* A path over too many periods of a repeated mesh. */
#define CML_PATH_TOO_LONG 2

/* The closest crossing of a ray with a mesh and its outer plane: p in the boundary's frame and from the
 * scene's origin, cm; u unit; below: the packet is below the boundary; t_max: length of the path, cm.
 * exclude: the primitive the packet stands on, -1, CML_NEAR_FACETS or CML_OFF_FACETS. undeflected: it has
 * come through that primitive undeflected, so what lies behind it on the same line has been dealt with.
 * err_position: a crossing up to so far behind p is one at p, because rounding has put the packet beyond a
 * facet that it has not crossed, cm. exact: test all candidates in double; else the fastest way to find the
 * hit, which alone is computed in double. Returns 1 and fills *crossing when there is one with t < t_max.
 * ends_near_facet is always filled.
 */
typedef int cml_mesh_intersect(const struct cml_mesh_surface *mesh, const double p[3], const double u[3],
                               int below, double t_max, int exclude, int undeflected, int exact,
                               double err_position, struct cml_mesh_crossing *crossing);

#endif
