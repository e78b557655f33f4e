/* SPDX-License-Identifier: MIT */
#include "tally/deal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The fraction of a photon that rounding down took from a beam. */
struct remainder {
    long double part;
    int beam;
};

/* Orders remainders by falling size, and equal ones by beam. */
static int compare_remainders(const void *a, const void *b)
{
    const struct remainder *x = a, *y = b;
    if (x->part != y->part) return x->part < y->part ? 1 : -1;
    return (x->beam > y->beam) - (x->beam < y->beam);
}

/* Each beam gets the whole part of its quota, then one photon each goes to the beams with the largest
 * remainders. */
cml_status cml_deal_numbers(const double *share, int count, uint64_t photons, uint64_t *number,
                            struct cml_error *err)
{
    CML_FREED struct remainder *remainder = malloc((size_t)count * sizeof *remainder);
    long double sum = 0;
    uint64_t left = photons;
    if (!remainder) return cml_fail_memory(err, count * (double)sizeof *remainder, "the beams");
    for (int k = 0; k < count; k++) sum += share[k];
    for (int k = 0; k < count; k++) {
        const long double quota = (long double)photons * share[k] / sum, whole = floorl(quota);
        number[k] = (uint64_t)whole < left ? (uint64_t)whole : left;
        remainder[k] = (struct remainder){quota - whole, k};
        left -= number[k];
    }
    qsort(remainder, (size_t)count, sizeof *remainder, compare_remainders);
    for (int k = 0; left > 0; k = (k + 1) % count, left--) number[remainder[k].beam]++;
    return CML_OK;
}

cml_status cml_deal_create(const double *share, int count, struct cml_deal *deal, struct cml_error *err)
{
    *deal = (struct cml_deal){.count = count, .share = share};
    if (count == 1) return CML_OK;
    deal->before = calloc((size_t)count + 1, sizeof *deal->before);
    deal->after = calloc((size_t)count + 1, sizeof *deal->after);
    if (deal->before && deal->after) return CML_OK;
    cml_deal_clear(deal);
    return cml_fail_memory(err, 2.0 * count * sizeof(uint64_t), "the beams");
}

void cml_deal_clear(struct cml_deal *deal)
{
    free(deal->before);
    free(deal->after);
    *deal = (struct cml_deal){0};
}

/* Sets sums[k] to the number of photons of all beams before beam k, of `photons` in all. */
static cml_status sum_numbers(const struct cml_deal *deal, uint64_t photons, uint64_t *sums,
                              struct cml_error *err)
{
    CML_TRY(cml_deal_numbers(deal->share, deal->count, photons, sums + 1, err));
    for (int k = 0; k < deal->count; k++) sums[k + 1] += sums[k];
    return CML_OK;
}

/* Returns how many of the photons 0 to photons - 1 belong to a batch. */
static uint64_t in_batch(uint64_t photons, uint64_t batch)
{
    return photons / CML_NUM_BATCHES + (batch < photons % CML_NUM_BATCHES);
}

/* Returns how many photons of a batch belong to beam k. sums: running sums of photons over the beams. */
static uint64_t of_beam(const uint64_t *sums, int k, uint64_t batch)
{
    return in_batch(sums[k + 1], batch) - in_batch(sums[k], batch);
}

cml_status cml_deal_round(struct cml_deal *deal, uint64_t begin, uint64_t end, struct cml_error *err)
{
    deal->begin = begin;
    deal->end = end;
    if (deal->count == 1) return CML_OK;
    CML_TRY(sum_numbers(deal, begin, deal->before, err));
    CML_TRY(sum_numbers(deal, end, deal->after, err));
    for (int k = 0; k < deal->count; k++)
        for (uint64_t batch = 0; batch < CML_NUM_BATCHES; batch++)
            if (of_beam(deal->before, k, batch) > of_beam(deal->after, k, batch))
                return cml_fail(err, CML_E_INPUT,
                                "%llu photons after %llu (expected another number: a batch would lose "
                                "photons of beam %d)",
                                (unsigned long long)(end - begin), (unsigned long long)begin, k + 1);
    return CML_OK;
}

/* The upper bits of a photon's number name the beam, the rest count the beam's own photons. */
bool cml_deal_has(const struct cml_deal *deal, uint64_t photon)
{
    const uint64_t beam = photon >> CML_SOURCE_SHIFT, own = photon - (beam << CML_SOURCE_SHIFT);
    if (deal->count == 1) return photon < deal->end;
    return beam < (uint64_t)deal->count &&
           own / CML_NUM_BATCHES < of_beam(deal->after, (int)beam, own % CML_NUM_BATCHES);
}

/* A piece ends with the beam's photons in the batch, or at a multiple of 2^32 points, where the lattice gets
 * new shifts (`sheet`: one such range of points). */
struct cml_piece cml_deal_piece_at(const struct cml_deal *deal, uint64_t turn)
{
    const struct cml_piece all = cml_piece_at(deal->begin, deal->end, turn);
    if (deal->count == 1) return all;
    const uint64_t batch = (uint64_t)all.batch, sheet = (uint64_t)1 << 32;
    uint64_t point =
        /* Number of the point among those of the batch in this round. */
        all.first / CML_NUM_BATCHES - in_batch(deal->begin, batch);
    for (int k = 0;; k++) {
        const uint64_t before = of_beam(deal->before, k, batch),
                       more = of_beam(deal->after, k, batch) - before;
        if (point < more) {
            const uint64_t first = before + point, left = sheet - first % sheet;
            const uint64_t count = more - point < left ? more - point : left;
            return (struct cml_piece){((uint64_t)k << CML_SOURCE_SHIFT) + batch + CML_NUM_BATCHES * first,
                                      count, all.batch};
        }
        point -= more;
    }
}
