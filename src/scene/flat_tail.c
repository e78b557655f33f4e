/* SPDX-License-Identifier: MIT */
#include "scene/flat_tail.h"

#include <math.h>
#include <stdlib.h>

/* An interval ends at the direction that the next smaller index totally reflects: cos = sqrt(1 - share^2). */
double cml_flat_tail_widest(const struct cml_flat_tail *tail, int interval)
{
    const double share = interval > 0 ? tail->index[interval - 1] / tail->index[interval] : 0;
    return pow((1 - share) * (1 + share), 0.25);
}

bool cml_flat_tail_has(const struct cml_flat_tail *tail, int score)
{
    const int rows = tail->intervals * (CML_FLAT_TAIL_CELLS + 1);
    for (int j = 0; j < rows; j++)
        if (tail->response[(size_t)j * (size_t)tail->scores + (size_t)score] > 0) return true;
    return false;
}

void cml_flat_tail_clear(struct cml_flat_tail *tail)
{
    free(tail->index);
    free(tail->response);
    free(tail->exponent);
    *tail = (struct cml_flat_tail){0};
}
