/* The surfaces of a scene's bodies as queries want them, the trees over the bodies of each medium, and the
 * grids by which most steps need no query. Places in the frame of the body's layer (kernels/types.h), but x
 * and y of the scene; cm. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "boundary.h"
#include "scene/scene.h"
#include "surface/bounds/body_grid.h"
#include "surface/body/body_tree.h"
#include "surface/mesh/mesh_surface.h"

struct cml_body_surface {
    enum cml_surface_kind kind;
    double lower[3], upper[3];     /* box */
    double depth;                  /* of the frame, scene, cm */
    struct cml_mesh_surface *mesh; /* CML_SURFACE_MESH */
    uint64_t primitives;           /* facets: triangles, 1 of a sphere, 3 of a cylinder */
    uint64_t first;                /* of them among those of all bodies */
};

struct cml_body_surfaces {
    int count;                     /* bodies */
    struct cml_body_surface *item; /* [count] */
    struct cml_body_tree tree;
    struct cml_body_grids grids;
    const struct cml_scene_body *of; /* the bodies, which scenes share */
    int *users;                      /* scenes that share what it points to (base/shared.h) */
};

/* origin: scene position of x and y of queries. depths: [num_layers] of the frames of layers 1..L, cm.
 * tolerance: spheres and cylinders become meshes that are off by no more than this share of their radius; 0:
 * they stay what they are. CML_E_INPUT when memory runs out, such meshes meet or a body is too small for
 * where it lies, CML_E_DEVICE when Embree fails; then nothing is left to free. */
CML_NODISCARD cml_status cml_body_surfaces_create(const struct cml_scene *scene, const double origin[2],
                                                  const double *depths, double tolerance,
                                                  enum cml_mesh_search search,
                                                  struct cml_body_surfaces *surfaces, struct cml_error *err);

/* Shares the surfaces of another scene that shares its bodies, in the same frames. */
void cml_body_surfaces_share(const struct cml_body_surfaces *from, struct cml_body_surfaces *surfaces);

void cml_body_surfaces_free(struct cml_body_surfaces *surfaces);

/* Area of a facet of the body as it is represented, cm^2. */
double cml_body_facet_area(const struct cml_body_surface *surface, const struct cml_scene_body *body,
                           size_t facet);
