/* SPDX-License-Identifier: MIT */
#include "scene/window_table.h"

#include <math.h>
#include <stdlib.h>

cml_status cml_window_table_create(const double *importance, double start, double power,
                                   struct cml_window_table *to, struct cml_error *err)
{
    const size_t count = (size_t)to->cells * (size_t)to->rings;
    to->target = calloc(count, sizeof *to->target);
    if (!to->target) return cml_fail_memory(err, (double)(count * sizeof *to->target), "weight windows");
    for (size_t i = 0; i < count; i++) {
        const double share = pow(start / importance[i], power);
        to->target[i] = (uint32_t)fmax(0x1p31 * fmin(share, 1), CML_LEAST_TARGET);
    }
    return CML_OK;
}

void cml_window_table_clear(struct cml_window_table *windows)
{
    free(windows->target);
    *windows = (struct cml_window_table){0};
}
