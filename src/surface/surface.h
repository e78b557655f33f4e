/* Represents each boundary of a scene as a plane, as cones or as a mesh, and says why.
 * The cheapest exact representation is chosen: level heightfields become planes, and rings on a straight line
 * are merged. Radial heightfields become exact cones. Meshes that are sheets are searched by walking a grid
 * of cells, other meshes by a tree. A representation can be forced, so that methods can be compared with each
 * other.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/body/body_surface.h"
#include "surface/bounds/depth_map.h"
#include "scene/scene.h"
#include "surface/surface_choice.h"
#include "surface/surface_origin.h"
#include "surface/mesh/mesh_surface.h"

/* One represented boundary. Its coordinates count z from `depth` in the scene. Owns everything that it points
 * to, unless it shares it (`users`). */
struct cml_surface_def {
    enum cml_surface_kind kind;
    char reason[160];           /* why this kind was chosen, for people */
    struct cml_rough_def rough; /* the boundary's roughness */
    double depth;               /* scene depth of z = 0, cm; for a plane the depth of the plane itself */
    double steepest; /* greatest slope of any part, cm per cm; infinite if a part is upright or overhangs */
    double lowest, highest;        /* lowest <= z <= highest everywhere, cm */
    uint64_t primitives;           /* number of rings or triangles; 1 for a plane */
    int num_rings;                 /* number of rings of CML_SURFACE_CONE */
    double *r, *z, *slope;         /* [num_rings], as described in kernels/types.h */
    struct cml_mesh_surface *mesh; /* the searched mesh of CML_SURFACE_MESH */
    struct cml_depth_map depths;   /* bounds of depths and horizons of cones and meshes */
    struct cml_expectation expectation;
    const int *shape; /* reference count of the scene boundary with this shape, which identifies the shape;
                         NULL: none */
    int *users;       /* reference count of scenes that share this surface's memory (base/shared.h) */
    double build_seconds, bytes; /* time and memory for the tree, the rings and the bounds */
};

struct cml_surface_set {
    int count;                    /* number of boundaries: num_layers + 1 */
    struct cml_surface_def *item; /* [count] surfaces of the boundaries, from above */
    struct cml_body_surfaces bodies;
    struct cml_origin origin; /* origin of x and y in meshes and bodies */
};

/* Represents every boundary and every body of the scene. Returns CML_E_INPUT if a boundary cannot have the
 * forced kind, if a tessellation exceeds the budget, or if cml_surface_origin refuses the scene. */
CML_NODISCARD cml_status cml_surfaces_create(const struct cml_scene *scene,
                                             const struct cml_surface_options *options,
                                             struct cml_surface_set *set, struct cml_error *err);

/* Frees all surfaces of a scene, unless other scenes share them, and zeroes the structure. */
void cml_surfaces_free(struct cml_surface_set *set);

/* True if all boundaries are planes, and there are no bodies. */
bool cml_surfaces_are_planes(const struct cml_surface_set *set);

/* True if all boundaries are planes without roughness, and there are no bodies. */
bool cml_surfaces_are_smooth_planes(const struct cml_surface_set *set);

/* Makes *def the plane in which a curved boundary continues outside, for a tile the plane at its mean height.
 * Overwrites *def without freeing it; the plane owns no memory. */
void cml_surface_make_outer_plane(const struct cml_boundary *boundary, struct cml_surface_def *def);

/* Makes the outer plane of a boundary, like cml_surface_make_outer_plane, but as rings of cones without a
 * slope. Packets then take the same events with the same random numbers as on curved boundaries. (At normal
 * incidence on a plane, packets start behind the first boundary.) The caller clears *def, also on failure. */
CML_NODISCARD cml_status cml_surface_make_level_rings(const struct cml_boundary *boundary,
                                                      struct cml_surface_def *def, struct cml_error *err);

/* Frees the memory of one boundary and makes it a plane at z = 0. */
void cml_surface_clear(struct cml_surface_def *def);

/* Returns the name of a kind: "plane", "cone", "mesh", "auto", "sphere" or "cylinder". */
const char *cml_surface_kind_name(enum cml_surface_kind kind);

/* Makes the mesh of boundary b for `clustermcml mesh`: loaded or tessellated, as cml_surfaces_create would
 * search it. A tile gives one period, without cml_mesh_prepare. A plane gives an empty mesh. */
CML_NODISCARD cml_status cml_boundary_mesh(const struct cml_scene *scene, int b,
                                           const struct cml_surface_options *options, struct cml_mesh *mesh,
                                           struct cml_error *err);
