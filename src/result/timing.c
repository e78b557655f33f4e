/* SPDX-License-Identifier: MIT */
#include "result/timing.h"

#include <stdlib.h>

/* The times of all ranks together. */
static struct cml_rank_report sum_of(const struct cml_timing *timing)
{
    struct cml_rank_report sum = {0};
    for (int i = 0; i < timing->ranks; i++) {
        const struct cml_rank_report *rank = &timing->rank[i];
        sum.waiting += rank->waiting;
        sum.asking += rank->asking + rank->summing;
        sum.elapsed += rank->elapsed;
        sum.processor += rank->processor;
    }
    return sum;
}

double cml_timing_processor(const struct cml_timing *timing)
{
    return sum_of(timing).processor;
}

/* Weighted by time, not the mean of the ranks' shares: a rank that was there for a short time counts for
 * little. */
double cml_timing_idle(const struct cml_timing *timing)
{
    const struct cml_rank_report sum = sum_of(timing);
    return sum.elapsed > 0 ? sum.waiting / sum.elapsed : 0;
}

double cml_timing_communication(const struct cml_timing *timing)
{
    const struct cml_rank_report sum = sum_of(timing);
    return sum.elapsed > 0 ? sum.asking / sum.elapsed : 0;
}

void cml_record_clear(struct cml_record *record)
{
    free(record->json);
    *record = (struct cml_record){0};
}
