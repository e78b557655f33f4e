/* Estimates matrices of a rough plane by walks. Walks start exactly in the direction of a node j. Their power
 * is shared out to nodes i by the polynomials through the nodes, which are orthogonal over etendue. So e_j
 * P_ij, with the etendues e, is a Galerkin matrix but for the quadrature over j. It is symmetric but for
 * noise, because walks are reciprocal. The mean of the matrix and its transpose is exactly symmetric and has
 * half the noise. SPDX-License-Identifier: MIT */
#include "exact/rough_response.h"

#include "exact/rough_walk.h"
#include "vector/processor.h"

#include <math.h>
#include <string.h>

extern cml_rough_walker *const cml_rough_walker_base;
#ifdef CML_X86_LEVELS
extern cml_rough_walker *const cml_rough_walker_v3, *const cml_rough_walker_v4;
#endif

/* Returns the walks at rough boundaries as compiled for the best instructions of this processor. */
static cml_rough_walker *best_walker(void)
{
#ifdef CML_X86_LEVELS
    if (cml_processor_level() >= 4) return cml_rough_walker_v4;
    if (cml_processor_level() >= 3) return cml_rough_walker_v3;
#endif
    return cml_rough_walker_base;
}

/* The state of estimating one boundary's matrices. */
struct work {
    const struct cml_rough_plane *plane;
    const struct cml_directions *directions;
    int above, below, all;
    struct cml_rough_interval *interval; /* [directions->num_weighted] intervals between indices, rising */
    double *factor;                      /* [directions->count] barycentric factors of the intervals' nodes */
    double *share;                       /* [directions->count] scratch */
    double *walked;                      /* [all][all] power from each direction (row) into each */
    unsigned seed;
};

/* Sets up an interval of refractive indices with its nodes. Its upper end is the index of node `first`, and
 * its lower end is `below`. Its nodes are those from `first` on that have this upper index. The factors of
 * the barycentric formula are from Wang, Xiang, Math. Comput. 81, 861 (2012). */
static void add_interval(struct work *w, struct cml_rough_interval *to, int first, double below)
{
    const struct cml_directions *d = w->directions;
    const double n = d->index[first], most = sqrt((n - below) * (n + below)) / n;
    *to = (struct cml_rough_interval){n, first, 0, d->cosine + first, w->factor + first};
    for (int i = first; i < d->count && d->etendue[i] > 0 && d->index[i] == n; i++) {
        const double x = 2 * d->cosine[i] / most - 1, weight = d->etendue[i] / d->cosine[i];
        w->factor[i] = (i % 2 ? -1 : 1) * sqrt((1 - x * x) * weight);
        to->count++;
    }
}

/* Finds the intervals of directions between neighbouring refractive indices, each with its own nodes of
 * quadrature. */
static void find_intervals(struct work *w)
{
    const struct cml_directions *d = w->directions;
    struct cml_rough_interval *to = w->interval;
    double below = 0;
    for (int k = 0; k < d->num_weighted; k += to++->count) {
        add_interval(w, to, d->weighted[k], below);
        below = to->index;
    }
}

/* Returns the number of walks from direction j in one part. Half of all walks follow the power that nodes
 * carry in diffuse light, a quarter is spread evenly over the nodes, and a quarter goes to light in
 * directions without weight. */
static int count_walks(const struct work *w, int j, bool from_below, double walks)
{
    const struct cml_directions *d = w->directions;
    double lit = 0, power = 0, nodes = 0;
    for (int i = 0; i < w->all; i++) {
        const int direction = i < w->above ? i : i - w->above;
        if (i < w->above && w->plane->lit) lit += fabs(d->light[i]);
        nodes += d->etendue[direction] > 0;
        power += d->etendue[direction];
    }
    double share = d->etendue[j] > 0 ? 0.5 * d->etendue[j] / power + 0.25 / nodes : 0;
    if (lit > 0 && !from_below) share += 0.25 * fabs(d->light[j]) / lit;
    return (int)ceil(walks / CML_ROUGH_PARTS * share / (lit > 0 ? 1 : 0.75));
}

/* ---- matrices ---- */

/* Returns the weight of direction i, which counts those above the boundary first, then those below. */
static double etendue(const struct work *w, int i)
{
    return w->directions->etendue[i < w->above ? i : i - w->above];
}

/* Makes the walked powers of each pair of directions reciprocal, as physics demands. The diagonal
 * compensates the power that a column gains or loses. */
static void symmetrise(const struct work *w)
{
    const int n = w->all;
    double *P = w->walked;
    for (int j = 0; j < n; j++)
        for (int i = 0; i < j; i++) {
            const double to = etendue(w, i), from = etendue(w, j);
            if (!(to > 0 && from > 0)) continue;
            const double mean = 0.5 * (from * P[j * n + i] + to * P[i * n + j]);
            P[j * n + j] += P[j * n + i] - mean / from;
            P[i * n + i] += P[i * n + j] - mean / to;
            P[j * n + i] = mean / from;
            P[i * n + j] = mean / to;
        }
}

/* Copies the powers of all walks into the four matrices of a boundary. */
static void set_matrices(const struct work *w, struct cml_rough_matrices *to)
{
    const int a = w->above, b = w->below;
    for (int j = 0; j < w->all; j++)
        for (int i = 0; i < w->all; i++) {
            const double share = w->walked[j * w->all + i];
            if (j < a)
                *(i < a ? &to->R[i * a + j] : &to->T[(i - a) * a + j]) = share;
            else
                *(i < a ? &to->T_below[i * b + j - a] : &to->R_below[(i - a) * b + j - a]) = share;
        }
}

/* Makes one part of the random walks among facets of a rough boundary, from every direction on both sides,
 * and sums where they end. Directions 0 to above - 1 come from above, the others from below. */
static void walk_part(const struct work *w, int part, double walks, struct cml_rough_matrices *to)
{
    const struct cml_rough_plane *plane = w->plane;
    cml_rough_walker *const walker = best_walker();
    memset(w->walked, 0, (size_t)w->all * (size_t)w->all * sizeof *w->walked);
    for (int j = 0; j < w->all; j++) {
        const bool up = j >= w->above;
        const int direction = up ? j - w->above : j;
        const double near = up ? plane->below : plane->above;
        double *row = w->walked + (size_t)j * (size_t)w->all, *below = row + w->above;
        const struct cml_rough_start start = {.kind = (int)plane->rough.kind,
                                              .alpha = plane->rough.alpha,
                                              .near = near,
                                              .far = up ? plane->above : plane->below,
                                              .backed = plane->backing,
                                              .kept = plane->backing ? 1 - plane->backing->R : 0,
                                              .cosine = cml_directions_cosine(w->directions, direction, near),
                                              .key = {w->seed, (unsigned)direction, up},
                                              .part = part,
                                              .count = count_walks(w, direction, up, walks)};
        walker(&start, w->interval, w->share, up ? below : row, up ? row : below);
    }
    symmetrise(w);
    set_matrices(w, to);
}

/* Allocates reflection and transmission matrices of a rough boundary for light from above (R, T) and from
 * below. */
static struct cml_rough_matrices matrices_of(const struct work *w, struct cml_arrays *arrays)
{
    const size_t above = (size_t)w->above, below = (size_t)w->below;
    return (struct cml_rough_matrices){.R = cml_arrays_add(arrays, above * above, sizeof(double)),
                                       .T = cml_arrays_add(arrays, below * above, sizeof(double)),
                                       .R_below = cml_arrays_add(arrays, below * below, sizeof(double)),
                                       .T_below = cml_arrays_add(arrays, above * below, sizeof(double))};
}

/* Adds a part's matrix to the mean over all parts. */
static void add_mean(const double *part, size_t count, double *mean)
{
    for (size_t i = 0; i < count; i++) mean[i] += part[i] / CML_ROUGH_PARTS;
}

/* Walks all parts of the sample and sums their matrices into the mean. Standard errors come from the spread
 * of the parts. */
static void fill(const struct work *w, double walks, struct cml_rough_response *to)
{
    const size_t above = (size_t)w->above, below = (size_t)w->below;
    for (int k = 0; k < CML_ROUGH_PARTS; k++) {
        const struct cml_rough_matrices *part = &to->part[k];
        walk_part(w, k, walks, &to->part[k]);
        add_mean(part->R, above * above, to->mean.R);
        add_mean(part->T, below * above, to->mean.T);
        add_mean(part->R_below, below * below, to->mean.R_below);
        add_mean(part->T_below, above * below, to->mean.T_below);
    }
}

void cml_rough_response_clear(struct cml_rough_response *response)
{
    cml_arrays_free(&response->arrays);
    *response = (struct cml_rough_response){0};
}

cml_status cml_rough_response_create(const struct cml_rough_plane *plane,
                                     const struct cml_directions *directions, int above, int below,
                                     double walks, unsigned seed, struct cml_rough_response *to,
                                     struct cml_error *err)
{
    CML_AT_END(cml_arrays_free) struct cml_arrays arrays = {0};
    struct work w = {.plane = plane,
                     .directions = directions,
                     .above = above,
                     .below = below,
                     .all = above + below,
                     .seed = seed};
    const size_t count = (size_t)directions->count, all = (size_t)w.all;
    w.interval = cml_arrays_add(&arrays, count, sizeof *w.interval);
    w.factor = cml_arrays_add(&arrays, count, sizeof *w.factor);
    w.share = cml_arrays_add(&arrays, count, sizeof *w.share);
    w.walked = cml_arrays_add(&arrays, all * all, sizeof *w.walked);
    *to = (struct cml_rough_response){.above = above, .below = below};
    to->mean = matrices_of(&w, &to->arrays);
    for (int k = 0; k < CML_ROUGH_PARTS; k++) to->part[k] = matrices_of(&w, &to->arrays);
    CML_TRY(cml_arrays_check(&to->arrays, "a rough boundary", err));
    CML_TRY(cml_arrays_check(&arrays, "a rough boundary", err));
    find_intervals(&w);
    fill(&w, walks, to);
    return CML_OK;
}
