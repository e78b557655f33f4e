/* SPDX-License-Identifier: MIT */
#include "result/timing.h"

#include <stdlib.h>

/* Returns the times of all ranks added up. In the sum, `asking` stands for all communication: requests of
 * work and adding up of results. */
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

/* Returns the idle share weighted by time, so that a rank that was there for a short time counts little. */
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

int cml_record_find(const struct cml_record *record, enum cml_recorded kind, int i)
{
    if (i >= record->count[kind]) return -1;
    for (int k = 0; k < (int)kind; k++) i += (int)record->count[k];
    return i;
}

void cml_record_add(struct cml_record *record, enum cml_recorded kind, double value, double error)
{
    const int at = cml_record_find(record, kind, (int)record->count[kind]++);
    record->value[at] = value;
    record->error[at] = error;
}

/* True if the counts of a record read from a file fit the record's arrays, so that a damaged file cannot
 * lead to reads beyond them. */
bool cml_record_is_sound(const struct cml_record *record)
{
    const int64_t *n = record->count, fluxes = n[CML_RECORDED_FLUXES];
    for (int k = 0; k < CML_NUM_RECORDED; k++)
        if (n[k] < 0 || n[k] > CML_RECORD_NUMBERS) return false;
    return n[CML_RECORDED_TOTALS] < CML_NUM_TOTALS && n[CML_RECORDED_FACE] <= 1 &&
           n[CML_RECORDED_LAYERS] + n[CML_RECORDED_BODIES] <= CML_RECORD_MEDIA &&
           n[CML_RECORDED_EXPECTED] <= 1 + n[CML_RECORDED_LAYERS] &&
           n[CML_RECORDED_DETECTORS] <= CML_RECORD_MEDIA &&
           (fluxes == 0 || fluxes == CML_BODY_SIDES * n[CML_RECORDED_BODIES]);
}

void cml_record_clear(struct cml_record *record)
{
    free(record->json);
    *record = (struct cml_record){0};
}
