/* Surfaces of a scene's bodies for queries, trees over the bodies of each medium, and grids by which most
 * steps need no query. Places are in the frame of the body's layer (kernels/types.h), but with the scene's x
 * and y; cm. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "boundary.h"
#include "scene/scene.h"
#include "surface/bounds/body_grid.h"
#include "surface/body/body_tree.h"
#include "surface/mesh/mesh_surface.h"

struct cml_body_surface {
    enum cml_surface_kind kind;
    double lower[3], upper[3];     /* corners of the body's box */
    double depth;                  /* scene depth of the frame, cm */
    struct cml_mesh_surface *mesh; /* the searched mesh of CML_SURFACE_MESH */
    uint64_t primitives;           /* number of facets: triangles, 1 for a sphere, 3 for a cylinder */
    uint64_t first;                /* number of the first facet among the facets of all bodies */
};

struct cml_body_surfaces {
    int count;                     /* number of bodies */
    struct cml_body_surface *item; /* [count] surfaces of the bodies */
    struct cml_body_tree tree;
    struct cml_body_grids grids;
    const struct cml_scene_body *of; /* the scene's bodies, which scenes may share */
    int *users;                      /* reference count of scenes that share this memory (base/shared.h) */
};

/* Makes the surfaces of a scene's bodies. origin: scene position where x and y of queries are 0. depths:
 * [num_layers] of the frames of layers 1..L, cm. tolerance: spheres and cylinders become meshes that deviate
 * by at most this share of the radius; 0: they stay exact. Returns CML_E_INPUT if memory runs out, if such
 * meshes meet, or if a body is too small for its distance from the origin; CML_E_DEVICE if Embree fails.
 * After a failure nothing is left to free. */
CML_NODISCARD cml_status cml_body_surfaces_create(const struct cml_scene *scene, const double origin[2],
                                                  const double *depths, double tolerance,
                                                  enum cml_mesh_search search,
                                                  struct cml_body_surfaces *surfaces, struct cml_error *err);

/* Shares the surfaces of another scene that has the same bodies in the same frames. */
void cml_body_surfaces_share(const struct cml_body_surfaces *from, struct cml_body_surfaces *surfaces);

/* Frees the surfaces, unless other scenes share them, and zeroes the structure. */
void cml_body_surfaces_free(struct cml_body_surfaces *surfaces);

/* Returns the area of a facet of a body in its representation (exact or mesh), cm2. */
double cml_body_facet_area(const struct cml_body_surface *surface, const struct cml_scene_body *body,
                           size_t facet);
