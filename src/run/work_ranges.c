/* SPDX-License-Identifier: MIT */
#include "run/work_ranges.h"

#include "run/cluster.h"

#include <math.h>
#include <stdlib.h>

#define FIRST_WANT 1024
#define LEAST_PIECE 4096

/* Seconds that a range shall take. Rank 0 can answer some 1e5 questions per second; at this pace 1e4 ranks
 * ask 1e4. A piece shall take 25 times its overhead, a range two pieces at least. */
static double target_seconds(const struct cml_dispatch *dispatch)
{
    return fmax(0.5, fmax(1e-4 * cml_cluster_size(), 50 * dispatch->overhead));
}

/* Not below a sixteenth of what was asked for: that would cost more in questions than it saves in waiting. */
static uint64_t fair_count(struct cml_dispatch *dispatch, int rank, uint64_t want)
{
    if (cml_cluster_size() == 1) return want;
    dispatch->all_wants += want - dispatch->wants[rank];
    dispatch->wants[rank] = want;
    const cml_u128 half = dispatch->open->total / 2;
    const uint64_t fair = (uint64_t)(half * want / dispatch->all_wants), least = want / 16 + 1;
    if (fair > want) return want;
    return fair > least ? fair : least;
}

/* On rank 0, for any rank. */
static struct cml_range take(struct cml_dispatch *dispatch, int rank, uint64_t want, uint64_t flown)
{
    struct cml_range range = {0};
    pthread_mutex_lock(&dispatch->lock);
    dispatch->flown += flown;
    if (!cml_cluster_called()) {
        range = cml_ranges_take(dispatch->open, fair_count(dispatch, rank, want));
        if (range.count == 0) cml_cluster_call();
    }
    pthread_mutex_unlock(&dispatch->lock);
    return range;
}

static void answer(void *context, int rank, const struct cml_question *question, struct cml_answer *answer)
{
    const struct cml_range range = take(context, rank, question->want, question->flown);
    answer->first = range.first;
    answer->count = range.count;
}

cml_status cml_dispatch_open(struct cml_dispatch *dispatch, struct cml_ranges *open, double overhead,
                             struct cml_error *err)
{
    const size_t size = cml_cluster_rank() == 0 ? (size_t)cml_cluster_size() : 1;
    *dispatch = (struct cml_dispatch){
        .open = open, .overhead = overhead, .want = FIRST_WANT, .all_wants = size * FIRST_WANT};
    dispatch->wants = malloc(size * sizeof *dispatch->wants);
    if (!dispatch->wants) return cml_fail_memory(err, (double)size * 8, "the ranks");
    for (size_t i = 0; i < size; i++) dispatch->wants[i] = FIRST_WANT;
    pthread_mutex_init(&dispatch->lock, NULL);
    if (cml_cluster_rank() == 0) cml_cluster_serve(answer, dispatch);
    return CML_OK;
}

void cml_dispatch_close(struct cml_dispatch *dispatch)
{
    if (cml_cluster_rank() == 0) cml_cluster_serve(NULL, NULL);
    if (dispatch->wants) pthread_mutex_destroy(&dispatch->lock);
    free(dispatch->wants);
}

cml_status cml_dispatch_take(struct cml_dispatch *dispatch, uint64_t flown, struct cml_range *range,
                             struct cml_error *err)
{
    const struct cml_question question = {dispatch->want, flown};
    struct cml_answer answer;
    if (cml_cluster_rank() == 0) {
        *range = take(dispatch, 0, question.want, flown);
        return CML_OK;
    }
    CML_TRY(cml_cluster_ask(&question, &answer, err));
    *range = (struct cml_range){answer.first, answer.count};
    return CML_OK;
}

uint64_t cml_dispatch_piece(const struct cml_dispatch *dispatch)
{
    const double pieces = fmin(4, target_seconds(dispatch) / (25 * dispatch->overhead));
    return (uint64_t)fmax(LEAST_PIECE, (double)dispatch->want / pieces);
}

uint64_t cml_dispatch_flown(struct cml_dispatch *dispatch)
{
    pthread_mutex_lock(&dispatch->lock);
    const uint64_t flown = dispatch->flown;
    pthread_mutex_unlock(&dispatch->lock);
    return flown;
}

void cml_dispatch_timed(struct cml_dispatch *dispatch, struct cml_range range, double seconds)
{
    const double ratio = target_seconds(dispatch) / fmax(seconds, 1e-9);
    if (range.count < dispatch->want) return; /* cut short: says little of the speed */
    if (ratio > 0.67 && ratio < 2) return;
    const double want = (double)dispatch->want * fmin(8, fmax(0.25, ratio));
    dispatch->want = (uint64_t)fmin((double)CML_TALLY_MAX_PHOTONS, fmax(1, want));
}

/* What a rank brings to a meeting. */
struct returned {
    struct cml_range left;
    uint64_t flown;
    uint64_t stop;
};

static cml_status collect(struct cml_dispatch *dispatch, const struct returned *all, bool *stop,
                          struct cml_error *err)
{
    for (int i = 0; i < cml_cluster_size(); i++) {
        dispatch->flown += all[i].flown;
        *stop = *stop || all[i].stop;
        CML_TRY(cml_ranges_add(dispatch->open, all[i].left, err));
    }
    return CML_OK;
}

cml_status cml_dispatch_return(struct cml_dispatch *dispatch, struct cml_range left, uint64_t flown,
                               bool *stop, struct cml_error *err)
{
    const struct returned mine = {left, flown, *stop};
    const size_t size = cml_cluster_rank() == 0 ? (size_t)cml_cluster_size() : 1;
    struct returned *all = malloc(size * sizeof *all);
    cml_status status = all ? CML_OK : cml_fail_memory(err, (double)(size * sizeof *all), "the meeting");
    status = cml_cluster_agree(status, err);
    if (status == CML_OK) status = cml_cluster_gather(&mine, sizeof mine, all, err);
    if (status == CML_OK && cml_cluster_rank() == 0) status = collect(dispatch, all, stop, err);
    free(all);
    return cml_cluster_agree(status, err);
}
