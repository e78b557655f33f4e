/* New packets, prepared many at a time: the first draws of a range of photon indices in one vector loop.
 * SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_LAUNCH_H
#define CML_BUNDLE_LAUNCH_H

#include "optics.h"
#include "types.h"

#define CML_LAUNCHES 64

/* As cml_optical_depth but for the word 0: infinite, to be drawn later. */
CML_FN real cml_depth_or_tail(cml_u32 word)
{
    const real depth = -cml_log(cml_uniform(word));
    return word == 0u ? CML_INFINITY : depth;
}

/* Hands out the next range [*first, *first + *count) of photon indices; 0 when there is none. */
struct cml_range_source {
    int (*next)(void *context, uint64_t *first, uint64_t *count);
    void *context;
};

struct cml_launches {
    const struct cml_range_source *source;
    uint64_t first, left; /* of the range in hand: not prepared yet */
    uint64_t base;        /* index of entry 0 */
    int next, count;      /* entries next..count-1 wait for a lane */
    real tau[CML_LAUNCHES];
    cml_u32 draw1[CML_LAUNCHES], draw2[CML_LAUNCHES];
};

struct cml_launch {
    uint64_t index;
    real tau; /* optical depth to the first interaction */
    cml_u32 draw1, draw2;
};

static inline void cml_launches_draw(struct cml_launches *to, struct cml_stream stream)
{
    const uint64_t base = to->base;
#pragma omp simd
    for (int i = 0; i < CML_LAUNCHES; i++) {
        const struct cml_block draw = cml_draw(stream, base + (uint64_t)i, CML_PURPOSE_INTERACTION, 0);
        to->tau[i] = cml_depth_or_tail(draw.w[0]);
        to->draw1[i] = draw.w[1];
        to->draw2[i] = draw.w[2];
    }
}

/* Prepares up to CML_LAUNCHES packets; 0 when there are no more. */
static int cml_launches_prepare(struct cml_launches *to, struct cml_stream stream)
{
    while (to->left == 0)
        if (!to->source->next(to->source->context, &to->first, &to->left)) return 0;
    to->base = to->first;
    to->next = 0;
    to->count = to->left < CML_LAUNCHES ? (int)to->left : CML_LAUNCHES;
    to->first += (uint64_t)to->count;
    to->left -= (uint64_t)to->count;
    cml_launches_draw(to, stream);
    return 1;
}

/* The next packet; 0 when there are no more. */
static inline int cml_launches_next(struct cml_launches *from, const struct cml_setup *setup,
                                    struct cml_launch *launch)
{
    if (from->next == from->count && !cml_launches_prepare(from, setup->stream)) return 0;
    const int i = from->next++;
    launch->index = from->base + (uint64_t)i;
    launch->tau = from->tau[i];
    launch->draw1 = from->draw1[i];
    launch->draw2 = from->draw2[i];
    return 1;
}

#endif
