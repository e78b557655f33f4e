/* Finds rings that a radial heightfield does not need, from the samples alone. SPDX-License-Identifier:
 * MIT */
#include "scene/radial.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

bool cml_radial_is_flat(const struct cml_radial *radial)
{
    for (int i = 1; i < radial->n; i++)
        if (radial->h[i] != radial->h[0]) return false;
    return true;
}

void cml_radial_clear(struct cml_radial *radial)
{
    free(radial->r);
    free(radial->h);
    memset(radial, 0, sizeof *radial);
}

/* Allocates n radii and heights of a radial heightfield. */
static cml_status allocate(struct cml_radial *radial, int n, struct cml_error *err)
{
    const size_t bytes = (size_t)n * sizeof *radial->r;
    memset(radial, 0, sizeof *radial);
    radial->r = malloc(bytes);
    radial->h = malloc(bytes);
    if (radial->r && radial->h) return CML_OK;
    cml_radial_clear(radial);
    return cml_fail_memory(err, 2.0 * (double)bytes, "a radial heightfield");
}

/* Returns the number of samples without trailing ones that repeat the last height. Beyond the last sample the
 * surface is level anyway. */
static int count_without_tail(const struct cml_radial *radial)
{
    int n = radial->n;
    while (n > 1 && radial->h[n - 2] == radial->h[n - 1]) n--;
    return n;
}

/* The range of slopes with which a line from one sample passes all later samples within their rounding. */
struct slopes {
    double lowest, highest;
};

static double slope_between(const struct cml_radial *radial, int a, int b)
{
    return (radial->h[b] - radial->h[a]) / (radial->r[b] - radial->r[a]);
}

/* Narrows the range of slopes, so that the line passes sample i within the rounding of its height and
 * radius. */
static void narrow_slopes(struct slopes *slopes, const struct cml_radial *radial, int anchor, int i)
{
    const double slope = slope_between(radial, anchor, i);
    const double run = radial->r[i] - radial->r[anchor];
    const double height = fmax(fabs(radial->h[anchor]), fabs(radial->h[i]));
    const double err_slope = 4.0 * DBL_EPSILON * (height + fabs(slope) * radial->r[i]) / run;
    slopes->lowest = fmax(slopes->lowest, slope - err_slope);
    slopes->highest = fmin(slopes->highest, slope + err_slope);
}

/* Returns the furthest sample (< n) that a straight line from `anchor` reaches while it passes through all
 * samples between. Slopes are compared from the anchor, not from neighbour to neighbour, so that small bends
 * cannot add up unseen. The allowed slopes form a wedge that every sample narrows [J. Sklansky and V.
 * Gonzalez, Fast polygonal approximation of digitized curves, Pattern Recognition 12 (1980) 327]. */
static int furthest_on_line(const struct cml_radial *radial, int anchor, int n)
{
    struct slopes slopes = {-INFINITY, INFINITY};
    int furthest = anchor + 1;
    for (int i = anchor + 1; i < n; i++) {
        const double slope = slope_between(radial, anchor, i);
        if (slope >= slopes.lowest && slope <= slopes.highest) furthest = i;
        narrow_slopes(&slopes, radial, anchor, i);
        if (slopes.lowest > slopes.highest) break;
    }
    return furthest;
}

/* Goes from the axis outwards and lets each line reach as far as it can. */
cml_status cml_radial_merge(const struct cml_radial *from, struct cml_radial *to, struct cml_error *err)
{
    const int n = count_without_tail(from);
    CML_TRY(allocate(to, n, err));
    for (int i = 0; i < n; i = i + 1 < n ? furthest_on_line(from, i, n) : n) {
        to->r[to->n] = from->r[i];
        to->h[to->n] = from->h[i];
        to->n++;
    }
    return CML_OK;
}
