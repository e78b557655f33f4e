/* The scene as the kernels read it: struct cml_world, in the precision of the file that includes this (`real`
 * of kernels/port.h: double where CML_DOUBLE is defined, else float).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/array.h"
#include "engine/engine.h"
#include "engine/phase_table.h"
#include "types.h"

/* world.c is compiled once per precision (world_double.c); so that both can be linked, the functions of the
 * double one have names of their own. */
#ifdef CML_DOUBLE
#define cml_copy_bodies cml_copy_bodies_double
#define cml_source_bytes cml_source_bytes_double
#define cml_source_media cml_source_media_double
#define cml_source_medium cml_source_medium_double
#define cml_set_detectors cml_set_detectors_double
#define cml_set_sources cml_set_sources_double
#define cml_owned_world_create cml_owned_world_create_double
#define cml_owned_world_free cml_owned_world_free_double
#define cml_world_bytes cml_world_bytes_double
#endif

/* A world and the arrays it points into. The meshes belong to the surfaces it was made from. */
struct cml_owned_world {
    struct cml_world world;
    struct cml_arrays arrays;     /* all but detector_start and detector_list */
    struct cml_medium *media;     /* [num_layers + 2 + num_bodies] */
    struct cml_surface *surfaces; /* [num_layers + 1 + num_bodies] */
    real *rings;      /* [CML_RING_ROWS][num_rings]: ring_r, ring_z, ring_slope and both horizons */
    int *ring_starts; /* [num_rings] */
    real *depths;     /* [2][depth_cells]: deepest, highest (kernels/bounds.h) */
    real *horizons;   /* [2][horizon_cells] of meshes: seen from below, from above */
    const struct cml_mesh_surface **meshes; /* of surfaces, NULL where one is no mesh */
    struct cml_safe_cells *safe_cells;      /* of boundaries; what they point to belongs to the surfaces */
    struct cml_body *bodies;                /* [num_bodies] */
    struct cml_body_node *body_nodes;
    struct cml_body_grid *body_grids;
    struct cml_body_cell *body_cells;
    struct cml_source *sources; /* [num_beams] */
    struct cml_light_cell *light_cells;
    cml_u32 *image_words;
    struct cml_detector *detectors; /* [num_detectors] */
    struct cml_detector_level *detector_levels;
    int *detector_start, *detector_list;
    real *row_more, *row_hits, *row_part, *row_most; /* as in struct cml_rows */
    size_t num_light_cells, num_image_words;
    size_t num_body_nodes, num_body_grids, num_body_cells;
    struct cml_tail_interval *tail_intervals;
    cml_u32 *lowest;                    /* weights, of windows */
    struct cml_phase_cell *phase_cells; /* [num_phase_cells] */
    size_t num_phase_cells;
    size_t num_rings, depth_cells, horizon_cells; /* of all boundaries together */
};

/* Makes *to, which is the caller's to free; scene and surfaces must outlive it. Fails when memory runs out,
 * and then there is nothing to free. */
CML_NODISCARD cml_status cml_owned_world_create(const struct cml_scene *scene,
                                                const struct cml_surface_set *surfaces,
                                                const struct cml_engine_options *options,
                                                struct cml_owned_world *to, struct cml_error *err);
void cml_owned_world_free(struct cml_owned_world *to);

/* Bytes that a world takes, and while it is made: of phase functions at most, which is known when their
 * tables are there. */
double cml_world_bytes(const struct cml_scene *scene, const struct cml_surface_set *surfaces);

/* Bytes of cml_world_bytes that the beams take. */
double cml_source_bytes(const struct cml_scene *scene);

/* In which medium the middle of a beam lies; 0 of one that starts above all surfaces. */
int cml_source_medium(const struct cml_world *world, const struct cml_beam *beam);

/* In which medium the middle of each beam lies: (*medium)[num_beams], the caller's to free; 0 for those that
 * start above all surfaces. CML_E_INPUT where a beam cannot start there, or memory runs out. */
CML_NODISCARD cml_status cml_source_media(const struct cml_scene *scene,
                                          const struct cml_surface_set *surfaces, int **medium,
                                          struct cml_error *err);
