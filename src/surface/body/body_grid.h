/* How far it surely is from the places of a medium to the surfaces of its bodies: cells of equal size, each
 * with a lower bound, by which most steps need no query (kernels/body.h, cml_body_clearance).
 * SPDX-License-Identifier: MIT */
#ifndef CML_BODY_GRID_H
#define CML_BODY_GRID_H

#include "base/status.h"
#include "scene/scene.h"

#include <stddef.h>

/* The cells of one medium. */
struct cml_body_cells {
    int n[3];
    size_t first;              /* of its cells among all, x fastest */
    double corner[3], cell[3]; /* frame of the layer, scene x and y; cm */
};

struct cml_body_grids {
    int count;
    struct cml_body_cells *item; /* [count] */
    int *of_medium;              /* [num_media]: -1 none */
    size_t num_cells;
    float *clearance; /* [num_cells] cm, at most the least distance from any place of the cell */
};

/* Of all media with bodies and all bodies. depths: [num_media] of the frames. Cells are about a quarter of a
 * mean free path wide where few enough of them are. CML_E_INPUT when memory runs out; then the grids hold
 * what cml_body_grids_clear frees. */
CML_NODISCARD cml_status cml_body_grids_create(const struct cml_scene *scene, const double *depths,
                                               struct cml_body_grids *grids, struct cml_error *err);
void cml_body_grids_clear(struct cml_body_grids *grids);

#endif
