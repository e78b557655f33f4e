/* Code, included by each engine on the host, because packets have the engine's precision: the stack of
 * branches that wait for their flight (P19).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "windows.h"

#include <stdbool.h>
#include <stdlib.h>

/* Room of a stack, far more than ever wait in a scene whose windows are made for it: each packet in flight
 * leaves some tens of branches. */
#define CML_MOST_BRANCHES 16384

/* Frees the stack of one thread. */
static inline void cml_branches_free(struct cml_branches *branches)
{
    free(branches->item);
    free(branches->stay);
    *branches = (struct cml_branches){0};
}

/* Makes the stack of one thread; it has no memory if the world has no weight windows. CML_E_INPUT: memory
 * has run out. */
static inline cml_status cml_branches_create(const struct cml_world *world, struct cml_branches *to,
                                             struct cml_error *err)
{
    const size_t media = (size_t)world->setup.num_layers + 2 + (size_t)world->setup.num_bodies,
                 most = CML_MOST_BRANCHES;
    const bool trails = world->detection.num_detectors > 0;
    *to = (struct cml_branches){0};
    if (world->windows.cells == 0) return CML_OK;
    to->item = calloc(most, sizeof *to->item);
    if (trails) to->stay = calloc(most * media, sizeof *to->stay);
    if (!to->item || (trails && !to->stay)) {
        cml_branches_free(to);
        return cml_fail_memory(err, (double)most * sizeof *to->item, "packets that wait");
    }
    to->most = CML_MOST_BRANCHES;
    return CML_OK;
}
