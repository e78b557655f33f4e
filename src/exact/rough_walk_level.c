/* The walks of rough_walk.h. This file is compiled once for each level of the processor.
 * SPDX-License-Identifier: MIT */
#include "exact/rough_walk.h"

#include "rough.h"
#include "vector/processor.h"

#include <math.h>

/* The walks of one call. */
struct walks {
    const struct cml_rough_start *start;
    const struct cml_rough_interval *interval;
    struct cml_rough rough;
    struct cml_backing backing;
    struct cml_stream stream;
    struct cml_block shift[CML_LATTICE_EVENTS]; /* random shifts of the lattice */
    double *share, *to[2];                      /* scratch, and the power that goes back and beyond */
};

/* Shares the power of a finished walk out to nodes, by the barycentric formula [Berrut, Trefethen, SIAM
 * Review 46 (2004) 501, (4.2)]. The shares add up to 1. */
static void arrive(const struct walks *w, const struct cml_rough_walk *walk, double power)
{
    const double n = walk->beyond ? w->start->far : w->start->near, x = (double)walk->v.x,
                 y = (double)walk->v.y, square = n * n * (x * x + y * y);
    const struct cml_rough_interval *at = w->interval;
    while (at->index < n && square >= at->index * at->index) at++;
    const double cosine =
        at->index < n ? sqrt(1 - square / (at->index * at->index)) : fabs((double)walk->v.z);
    double *share = w->share, *to = w->to[walk->beyond] + at->first, sum = 0;
    for (int i = 0; i < at->count; i++) {
        const double off = cosine - at->cosine[i];
        share[i] = at->factor[i] / (off == 0 ? 1e-300 : off);
    }
    for (int i = 0; i < at->count; i++) sum += share[i];
    for (int i = 0; i < at->count; i++) to[i] += power / sum * share[i];
}

/* Returns the random words of walk k at facet number `step` of the walk. A lattice, which spreads walks
 * evenly, gives the words of the first facets. */
static struct cml_block draw(const struct walks *w, int k, int step)
{
    const cml_u64 photon = (cml_u64)k * CML_NUM_BATCHES + (cml_u64)w->start->part;
    const struct cml_block random = cml_draw(w->stream, photon, CML_PURPOSE_ROUGH, (cml_u32)step);
    if (step >= (int)CML_LATTICE_EVENTS) return random;
    return cml_lattice_block(cml_lattice_point(photon), (cml_u32)step, w->shift[step], random);
}

/* Reflects or refracts a walk at a facet with the normal m; `word` decides between the two. */
static void turn(const struct walks *w, struct cml_rough_walk *walk, struct cml_vec m, cml_u32 word)
{
    const real n[2] = {(real)w->start->near, (real)w->start->far};
    *walk = cml_rough_turn(*walk, m, n[walk->beyond], n[!walk->beyond], word);
}

/* Continues a walk from its first facet to its end, and adds its power to the direction in which it leaves.
 * A walk that meets too many facets ends in its last direction. */
static void finish(struct walks *w, struct cml_rough_walk walk, int k, double power)
{
    for (walk.steps = 1; walk.steps < CML_ROUGH_LIMIT; walk.steps++) {
        const struct cml_block block = draw(w, k, walk.steps);
        if (cml_rough_fly(w->rough, walk.v, &walk.e, block.w[0])) break;
        const struct cml_vec m = cml_rough_normal(w->rough, walk.v, block.w[1], block.w[2]);
        if (w->start->backed)
            power *= (double)cml_rough_mirror(&walk, m, &w->backing);
        else
            turn(w, &walk, m, block.w[3]);
    }
    arrive(w, &walk, power);
}

/* Makes one walk over the facets of a rough boundary. At the first facet the power divides into a reflected
 * and a transmitted part, both of which are followed, because this saves most of the noise. The word 0
 * forces reflection, all ones transmission. */
static void walk(struct walks *w, int k, double power)
{
    const double sine = sqrt(1 - w->start->cosine * w->start->cosine);
    const struct cml_block block = draw(w, k, 0);
    struct cml_rough_walk first = {{(real)sine, 0, (real)-w->start->cosine}, 0, 0, 0};
    if (cml_rough_fly(w->rough, first.v, &first.e, block.w[0])) return;
    const struct cml_vec m = cml_rough_normal(w->rough, first.v, block.w[1], block.w[2]);
    if (w->start->backed) {
        const double reflected = (double)cml_rough_mirror(&first, m, &w->backing);
        finish(w, first, k, power * reflected);
        return;
    }
    real ct;
    const double R =
        (double)cml_fresnel((real)w->start->near, (real)w->start->far, -cml_dot(first.v, m), &ct);
    for (cml_u32 way = 0; way < 2; way++) {
        const double part = power * (way ? 1 - R : R);
        struct cml_rough_walk one = first;
        if (!(part > 0)) continue;
        turn(w, &one, m, way ? 0xffffffffu : 0u);
        w->stream.key[3] = way;
        finish(w, one, k, part);
    }
    w->stream.key[3] = 0;
}

/* Makes all walks that start in one direction: a cml_rough_walker. back, beyond: what ends on the side of
 * the start, and on the other side, by direction. */
static void walk_all(const struct cml_rough_start *start, const struct cml_rough_interval *interval,
                     double *share, double *back, double *beyond)
{
    const unsigned *key = start->key;
    struct walks w = {.start = start,
                      .interval = interval,
                      .rough = {start->kind, (real)start->alpha},
                      .backing = {.kind = CML_BACKING_MIRROR, .kept = (real)start->kept},
                      .stream = {{key[0], key[1], key[2], 0}, 0},
                      .share = share,
                      .to = {back, beyond}};
    for (cml_u32 e = 0; e < CML_LATTICE_EVENTS; e++)
        w.shift[e] = cml_lattice_shifts(w.stream, (cml_u32)start->part, 0, e);
    for (int k = 0; k < start->count; k++) walk(&w, k, 1.0 / start->count);
}

/* declared only in rough_response.c, which chooses one level */
extern cml_rough_walker *const CML_LEVELED(cml_rough_walker_, CML_LEVEL);
cml_rough_walker *const CML_LEVELED(cml_rough_walker_, CML_LEVEL) = walk_all;
