/* What surfaces of bodies there are around the places of a layer: cubes that know balls without any, or where
 * in a ball they are, by which most steps need no query (kernels/body.h, cml_may_hit_body).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "scene/scene.h"
#include "surface/bounds/body_patch.h"

#include <stddef.h>

/* The cells of one layer, over all of its bodies. */
struct cml_body_cells {
    int n[3];
    size_t first;           /* of its cells among all, x fastest */
    double corner[3], cell; /* frame of the layer, scene x and y; width of a cell; cm */
};

struct cml_body_grids {
    int count;
    struct cml_body_cells *item; /* [count] */
    int *of_medium;              /* [num_media]: that of the layer, for bodies too; -1 none */
    size_t num_cells;
    struct cml_body_ball *ball; /* [num_cells] */
};

/* Makes the cells of all layers with bodies. origin: scene position of x and y in kernels; depths:
 * [num_media] of the frames. Cells are an eighth of the shortest mean free path wide, or as small as a
 * bounded number of them can be. CML_E_INPUT when memory runs out; then the grids hold what
 * cml_body_grids_clear frees. */
CML_NODISCARD cml_status cml_body_grids_create(const struct cml_scene *scene, const double origin[2],
                                               const double *depths, struct cml_body_grids *grids,
                                               struct cml_error *err);
void cml_body_grids_clear(struct cml_body_grids *grids);
