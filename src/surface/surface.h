/* How each boundary of a scene is represented: plane, cones or mesh, and why.
 * "No more than a scene needs": flat fields become planes, collinear rings are merged, radial fields are
 * marched as exact cones, meshes that are sheets are walked, other ones have a tree. A
 * representation can be forced, which is how methods judge each other. SPDX-License-Identifier: MIT */
#pragma once

#include "surface/body/body_surface.h"
#include "surface/bounds/depth_map.h"
#include "scene/scene.h"
#include "surface/surface_choice.h"
#include "surface/surface_origin.h"
#include "surface/mesh/mesh_surface.h"

/* One represented boundary, in its own frame, whose z = 0 lies at `depth` in the scene. Owns everything in
 * it. */
struct cml_surface_def {
    enum cml_surface_kind kind;
    char reason[160];           /* why this kind, for people */
    struct cml_rough_def rough; /* the boundary's */
    double depth;               /* of the frame; for a plane that of the plane itself */
    double steepest;        /* at least the slope of every part, infinite where it is upright or overhangs */
    double lowest, highest; /* lowest <= z <= highest everywhere */
    uint64_t primitives;    /* rings or triangles, 1 for a plane */
    int num_rings;          /* CML_SURFACE_CONE */
    double *r, *z, *slope;  /* [num_rings] see kernels/types.h */
    struct cml_mesh_surface *mesh; /* CML_SURFACE_MESH */
    struct cml_depth_map depths;   /* of cones and meshes */
    struct cml_expectation expectation;
    const int *shape;            /* the users of the boundary whose shape it is (cml_boundary); NULL: none */
    int *users;                  /* scenes that share what it points to (base/shared.h) */
    double build_seconds, bytes; /* what representing it took: tree, rings, bounds */
};

struct cml_surface_set {
    int count;                    /* num_layers + 1 */
    struct cml_surface_def *item; /* [count] */
    struct cml_body_surfaces bodies;
    struct cml_origin origin; /* from which meshes and bodies count x and y */
};

/* Represents every boundary of the scene, and its bodies. CML_E_INPUT when a boundary cannot take the forced
 * kind, a tessellation is over the budget, or cml_surface_origin refuses the scene. */
CML_NODISCARD cml_status cml_surfaces_create(const struct cml_scene *scene,
                                             const struct cml_surface_options *options,
                                             struct cml_surface_set *set, struct cml_error *err);

void cml_surfaces_free(struct cml_surface_set *set);

/* True if all boundaries are planes, and there are no bodies. */
bool cml_surfaces_are_planes(const struct cml_surface_set *set);
bool cml_surfaces_are_smooth_planes(const struct cml_surface_set *set);

/* The plane in which a curved boundary goes on outside, of a tile that of its mean height; owns nothing. What
 * *def was is overwritten. */
void cml_surface_make_outer_plane(const struct cml_boundary *boundary, struct cml_surface_def *def);

/* The plane of cml_surface_make_outer_plane as rings without a slope: packets take the events that they take
 * on curved boundaries, with the same random numbers (on a plane at normal incidence they start behind the
 * first one). The caller's to clear, also on failure. */
CML_NODISCARD cml_status cml_surface_make_level_rings(const struct cml_boundary *boundary,
                                                      struct cml_surface_def *def, struct cml_error *err);

/* Frees what one boundary owns, and makes it a plane at z = 0. */
void cml_surface_clear(struct cml_surface_def *def);

const char *cml_surface_kind_name(enum cml_surface_kind kind);

/* The mesh of boundary b as cml_surfaces_create would search it, tessellated or loaded; one period of
 * a tile, unprepared; empty (no triangles) for a plane. For `clustermcml mesh`. */
CML_NODISCARD cml_status cml_boundary_mesh(const struct cml_scene *scene, int b,
                                           const struct cml_surface_options *options, struct cml_mesh *mesh,
                                           struct cml_error *err);
