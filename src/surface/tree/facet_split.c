/* Divides facets into two groups by the surface area heuristic. SPDX-License-Identifier: MIT */
#include "surface/tree/facet_split.h"

#include <math.h>
#include <stdbool.h>

enum { BINS = 64 };

struct bin {
    struct cml_facet_box box;
    size_t count;
};

/* A way to divide boxes into two groups: by their middles along an axis, at the lower end of a bin. */
struct cut {
    int axis, bin;
    float least, bins_per_cm; /* smallest of the middles, times 2; bins per cm of twice the middle */
    double cost;
};

struct cml_facet_box cml_facet_box_none(void)
{
    return (struct cml_facet_box){{INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY}, 0};
}

void cml_facet_box_widen(struct cml_facet_box *box, const struct cml_facet_box *other)
{
    for (int k = 0; k < 3; k++) {
        box->at[k] = box->at[k] < other->at[k] ? box->at[k] : other->at[k];
        box->at[k + 3] = box->at[k + 3] > other->at[k + 3] ? box->at[k + 3] : other->at[k + 3];
    }
}

/* The chance that a ray meets a box is proportional to this area. */
float cml_facet_box_area(const struct cml_facet_box *box)
{
    const float x = box->at[3] - box->at[0], y = box->at[4] - box->at[1], z = box->at[5] - box->at[2];
    return x * y + y * z + z * x;
}

/* Returns twice the middle of a box along an axis, cm. */
static float twice_middle(const struct cml_facet_box *box, int axis)
{
    return box->at[axis] + box->at[axis + 3];
}

/* Returns the bin of a box along the cut's axis. */
static int bin_of(const struct cut *cut, const struct cml_facet_box *box)
{
    const int bin = (int)((twice_middle(box, cut->axis) - cut->least) * cut->bins_per_cm);
    return bin < BINS ? bin : BINS - 1;
}

/* Divides the range of boxes' middles along the cut's axis into bins, at whose borders cuts are tried.
 * Returns false if all middles are equal. */
static bool lay_bins(const struct cml_facet_box *box, size_t count, struct cut *cut)
{
    float least = INFINITY, most = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        least = fminf(least, twice_middle(&box[i], cut->axis));
        most = fmaxf(most, twice_middle(&box[i], cut->axis));
    }
    cut->least = least;
    cut->bins_per_cm = (float)BINS / (most - least);
    return cut->bins_per_cm < INFINITY;
}

/* Sorts boxes into bins along the cut's axis: the joint box and the number of boxes of each bin. */
static void fill_bins(const struct cml_facet_box *box, size_t count, const struct cut *cut,
                      struct bin bins[BINS])
{
    for (int i = 0; i < BINS; i++) bins[i] = (struct bin){cml_facet_box_none(), 0};
    for (size_t i = 0; i < count; i++) {
        struct bin *bin = &bins[bin_of(cut, &box[i])];
        cml_facet_box_widen(&bin->box, &box[i]);
        bin->count++;
    }
}

/* Returns the cost of a group: its surface times its number of leaves. A leaf that is not full costs as much
 * as a full one. */
static double cost_of(const struct bin *group, size_t leaf)
{
    return (double)cml_facet_box_area(&group->box) * (double)((group->count + leaf - 1) / leaf);
}

/* Adds a bin's boxes to a group. */
static void add_bin(struct bin *group, const struct bin *bin)
{
    cml_facet_box_widen(&group->box, &bin->box);
    group->count += bin->count;
}

/* Tries all cuts along the axis and keeps the best one in *best, if it is better than *best. */
static void try_cuts(const struct bin bins[BINS], const struct cut *along, size_t leaf, struct cut *best)
{
    double above[BINS];
    struct bin group = {cml_facet_box_none(), 0};
    for (int i = BINS - 1; i > 0; i--) {
        add_bin(&group, &bins[i]);
        above[i] = group.count ? cost_of(&group, leaf) : INFINITY;
    }
    group = (struct bin){cml_facet_box_none(), 0};
    for (int i = 1; i < BINS; i++) {
        add_bin(&group, &bins[i - 1]);
        const double cost = above[i] + (group.count ? cost_of(&group, leaf) : INFINITY);
        if (!(cost < best->cost)) continue;
        *best = *along;
        best->bin = i;
        best->cost = cost;
    }
}

/* Divides boxes in two at the cut: moves those below it to the front, and returns their number. */
static size_t part(struct cml_facet_box *box, size_t count, const struct cut *cut)
{
    size_t low = 0;
    for (size_t i = 0; i < count; i++) {
        if (bin_of(cut, &box[i]) >= cut->bin) continue;
        const struct cml_facet_box swapped = box[low];
        box[low++] = box[i];
        box[i] = swapped;
    }
    return low;
}

/* If all boxes have one centre, the halves are equal. */
size_t cml_facet_split(struct cml_facet_box *box, size_t count, size_t leaf)
{
    struct cut best = {.cost = INFINITY};
    for (int axis = 0; axis < 3; axis++) {
        struct cut along = {.axis = axis};
        struct bin bins[BINS];
        if (!lay_bins(box, count, &along)) continue;
        fill_bins(box, count, &along, bins);
        try_cuts(bins, &along, leaf, &best);
    }
    return best.cost < INFINITY ? part(box, count, &best) : (count + 1) / 2;
}
