/* The scene as the kernels read it: struct cml_world, in the precision of the file that includes this (`real`
 * of kernels/port.h: double where CML_DOUBLE is defined, else float).
 * SPDX-License-Identifier: MIT */
#ifndef CML_WORLD_H
#define CML_WORLD_H

#include "engine/engine.h"
#include "types.h"

/* world.c is compiled once per precision (world_double.c); so that both can be linked, the functions of the
 * double one have names of their own. */
#ifdef CML_DOUBLE
#define cml_owned_world_create cml_owned_world_create_double
#define cml_owned_world_free cml_owned_world_free_double
#endif

/* A world and the arrays it points into. The meshes belong to the surfaces it was made from. */
struct cml_owned_world {
    struct cml_world world;
    struct cml_medium *media;     /* [num_layers + 2] */
    struct cml_surface *surfaces; /* [num_layers + 1] */
    real *rings;      /* [CML_RING_ROWS][num_rings]: ring_r, ring_z, ring_slope and both horizons */
    int *ring_starts; /* [num_rings] */
    real *clearance;  /* [2][clearance_cells]: deepest, highest (kernels/clearance.h) */
    real *horizons;   /* [2][horizon_cells] of meshes: seen from below, from above */
    const struct cml_mesh_surface **meshes; /* [num_layers + 1], NULL where the boundary is no mesh */
    size_t num_rings, clearance_cells, horizon_cells; /* of all boundaries together */
};

/* Makes *to, which is the caller's to free; scene and surfaces must outlive it. Fails when memory runs out,
 * and then there is nothing to free. */
CML_NODISCARD cml_status cml_owned_world_create(const struct cml_scene *scene,
                                                const struct cml_surface_set *surfaces,
                                                const struct cml_engine_options *options,
                                                struct cml_owned_world *to, struct cml_error *err);
void cml_owned_world_free(struct cml_owned_world *to);

/* A vector rounded to `real`. */
static inline struct cml_vec cml_vec_of(double x, double y, double z)
{
    const struct cml_vec v = {(real)x, (real)y, (real)z};
    return v;
}

#endif
