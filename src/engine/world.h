/* The scene as the kernels read it: struct cml_world, in the precision of the file that includes this header
 * (`real` of kernels/port.h: double if CML_DOUBLE is defined, else float).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/array.h"
#include "engine/engine.h"
#include "engine/phase_table.h"
#include "types.h"

/* Names for double precision. world.c is compiled once per precision (world_double.c); its functions in
 * double have names of their own, so that both can be linked. */
#ifdef CML_DOUBLE
#define cml_copy_bodies cml_copy_bodies_double
#define cml_source_bytes cml_source_bytes_double
#define cml_source_media cml_source_media_double
#define cml_source_medium cml_source_medium_double
#define cml_add_level cml_add_level_double
#define cml_area_of cml_area_of_double
#define cml_set_contacts cml_set_contacts_double
#define cml_stopped_share cml_stopped_share_double
#define cml_set_detectors cml_set_detectors_double
#define cml_set_sources cml_set_sources_double
#define cml_owned_world_create cml_owned_world_create_double
#define cml_owned_world_free cml_owned_world_free_double
#define cml_world_bytes cml_world_bytes_double
#endif

/* Lists of the cells of grids over detectors or contacts, as struct cml_detector_level reads them. */
struct cml_cell_lists {
    int *start, *list, num_starts, num_entries;
};

/* A world with the arrays that it points into. Its meshes belong to the surfaces from which it was made. */
struct cml_owned_world {
    struct cml_world world;
    struct cml_arrays arrays;     /* all arrays but those of cell lists */
    struct cml_medium *media;     /* [num_layers + 2 + num_bodies] */
    struct cml_surface *surfaces; /* [num_layers + 1 + num_bodies] */
    real *rings;      /* [CML_RING_ROWS][num_rings]: ring_r, ring_z, ring_slope and both horizons */
    int *ring_starts; /* [num_rings] */
    real *depths;     /* [2][depth_cells]: deepest, highest (kernels/bounds.h) */
    real *horizons;   /* [2][horizon_cells] of meshes: for packets below, for packets above */
    const struct cml_mesh_surface **meshes; /* by surface; NULL for a surface that is no mesh */
    /* By boundary; the cells that they point to belong to the surfaces. */
    struct cml_safe_cells *safe_cells;
    struct cml_body *bodies; /* [num_bodies] */
    struct cml_body_node *body_nodes;
    struct cml_body_grid *body_grids;
    struct cml_body_cell *body_cells;
    struct cml_source *sources; /* [num_beams] */
    struct cml_light_cell *light_cells;
    cml_u32 *image_words;
    struct cml_detector *detectors; /* [num_detectors] */
    struct cml_detector_level *detector_levels;
    struct cml_contact *contacts; /* [num_contacts] */
    struct cml_cell_lists detector_cells, contact_cells;
    real *row_more, *row_hits, *row_part, *row_most; /* arrays of struct cml_rows */
    size_t num_light_cells, num_image_words;
    size_t num_body_nodes, num_body_grids, num_body_cells;
    struct cml_tail_interval *tail_intervals;
    cml_u32 *lowest;                    /* lower ends of the weight windows */
    struct cml_phase_cell *phase_cells; /* [num_phase_cells] */
    size_t num_phase_cells;
    size_t num_rings, depth_cells, horizon_cells; /* numbers for all boundaries together */
};

/* Makes *to, which the caller frees. Scene and surfaces must outlive it. Fails if memory runs out; then there
 * is nothing to free. */
CML_NODISCARD cml_status cml_owned_world_create(const struct cml_scene *scene,
                                                const struct cml_surface_set *surfaces,
                                                const struct cml_engine_options *options,
                                                struct cml_owned_world *to, struct cml_error *err);
void cml_owned_world_free(struct cml_owned_world *to);

/* Returns the bytes that a world takes, also while it is made. For phase functions this is an upper bound,
 * because their exact size is known only after their tables are made. */
double cml_world_bytes(const struct cml_scene *scene, const struct cml_surface_set *surfaces);

/* Returns the bytes of cml_world_bytes that the beams take. */
double cml_source_bytes(const struct cml_scene *scene);

/* Returns the medium in which the middle of a beam lies; 0 for a beam that starts above all surfaces. */
int cml_source_medium(const struct cml_world *world, const struct cml_beam *beam);

/* Finds the medium in which the middle of each beam lies: (*medium)[num_beams], which the caller frees; 0 for
 * beams that start above all surfaces. stopped: NULL, or [num_beams] for the shares of the beams that faces
 * and ports stop. CML_E_INPUT: a beam cannot start at its place, or memory runs out. */
CML_NODISCARD cml_status cml_source_media(const struct cml_scene *scene,
                                          const struct cml_surface_set *surfaces, int **medium,
                                          double *stopped, struct cml_error *err);
