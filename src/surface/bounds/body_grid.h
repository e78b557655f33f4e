/* Grids of cubes around the bodies of each layer. Each cube knows a ball around its middle that is free of
 * surfaces, or in which they lie between two planes, so that most steps need no query (kernels/body.h,
 * cml_may_hit_body). SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "scene/scene.h"
#include "surface/bounds/body_patch.h"

#include <stddef.h>

/* The cells of one layer, over all of its bodies. */
struct cml_body_cells {
    int n[3];
    size_t first;           /* index of the layer's first cell among all cells; x fastest */
    double corner[3], cell; /* lower corner, in the frame of the layer, x and y of the scene; width of a
                               cell; cm */
};

struct cml_body_grids {
    int count;
    struct cml_body_cells *item; /* [count], one per layer with bodies */
    int *of_medium;              /* [num_media] grid of each medium; a body's medium has its layer's grid;
                                    -1: none */
    size_t num_cells;
    struct cml_body_ball *ball; /* [num_cells] balls of all cells */
};

/* Makes the cells of all layers with bodies. origin: scene position where x and y in kernels are 0. depths:
 * [num_media] depth of each medium's frame, cm. A cell is an eighth of the shortest mean free path wide, or
 * wider if there would be too many cells. Returns CML_E_INPUT if memory runs out; cml_body_grids_clear then
 * still frees the grids. */
CML_NODISCARD cml_status cml_body_grids_create(const struct cml_scene *scene, const double origin[2],
                                               const double *depths, struct cml_body_grids *grids,
                                               struct cml_error *err);

/* Frees the grids' memory and zeroes the structure. */
void cml_body_grids_clear(struct cml_body_grids *grids);
