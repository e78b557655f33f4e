/* SPDX-License-Identifier: MIT */
#include "run/work_ranges.h"

#include "run/cluster/cluster.h"

#include <math.h>
#include <stdlib.h>

#define FIRST_WANT 1024  /* packets of a rank's first range, when its speed is not known yet */
#define LEAST_PIECE 4096 /* packets: smaller pieces leave threads and vector lanes without work */

/* Returns the seconds that flying a range should take. With 1e4 ranks or more a range takes 1e-4 s per rank:
 * rank 0 then gets 1e4 requests per second and can answer some 1e5. A piece should take 25 times its
 * overhead, and a range holds at least two pieces. */
static double target_seconds(const struct cml_work_ranges *work)
{
    return fmax(0.5, fmax(1e-4 * cml_cluster_size(), 50 * work->overhead));
}

/* Returns half of the rank's share of the photons left, but no more than the rank wants. Shares are in
 * proportion to what ranks last wanted, and hence to their speeds. A range has at least a sixteenth of what
 * was wanted, because requests for smaller ranges would cost more than they save in waiting. */
static uint64_t fair_count(struct cml_work_ranges *work, int rank, uint64_t want)
{
    if (cml_cluster_size() == 1) return want;
    work->all_wants += want - work->wants[rank];
    work->wants[rank] = want;
    const cml_u128 half = work->open->total / 2;
    const uint64_t fair = (uint64_t)(half * want / work->all_wants), least = want / 16 + 1;
    if (fair > want) return want;
    return fair > least ? fair : least;
}

/* Takes a range for any rank, on rank 0. If no photon is left, requests a synchronisation of all ranks,
 * because ranks that stop return photons there. */
static struct cml_range take(struct cml_work_ranges *work, int rank, uint64_t want, uint64_t flown)
{
    struct cml_range range = {0};
    pthread_mutex_lock(&work->lock);
    work->flown += flown;
    if (!cml_cluster_sync_requested(&work->sync)) {
        range = cml_ranges_take(work->open, fair_count(work, rank, want));
        if (range.count == 0) cml_cluster_request_sync(&work->sync);
    }
    pthread_mutex_unlock(&work->lock);
    return range;
}

/* Replies to another rank's request, in rank 0's service thread. */
static void reply_to(void *context, int rank, const struct cml_work_request *request,
                     struct cml_work_reply *reply)
{
    const struct cml_range range = take(context, rank, request->want, request->flown);
    reply->first = range.first;
    reply->count = range.count;
}

/* Gives all ranks the same small first range, because their speeds are not known yet. all_wants becomes the
 * sum of the first ranges. */
cml_status cml_work_open(struct cml_work_ranges *work, struct cml_ranges *open, struct cml_error *err)
{
    const size_t size = cml_cluster_rank() == 0 ? (size_t)cml_cluster_size() : 1;
    *work = (struct cml_work_ranges){.open = open, .want = FIRST_WANT, .all_wants = size * FIRST_WANT};
    CML_TRY(cml_zeros(&work->wants, size, sizeof *work->wants, "the ranks", err));
    for (size_t i = 0; i < size; i++) work->wants[i] = FIRST_WANT;
    pthread_mutex_init(&work->lock, NULL);
    if (cml_cluster_rank() == 0) cml_cluster_set_handler(reply_to, work);
    return CML_OK;
}

void cml_work_close(struct cml_work_ranges *work)
{
    if (cml_cluster_rank() == 0) cml_cluster_set_handler(NULL, NULL);
    if (work->wants) pthread_mutex_destroy(&work->lock);
    free(work->wants);
}

/* Takes a range for this rank. Rank 0 needs no message for its own ranges. */
cml_status cml_work_take(struct cml_work_ranges *work, uint64_t flown, struct cml_range *range,
                         struct cml_error *err)
{
    const struct cml_work_request request = {work->want, flown};
    struct cml_work_reply reply;
    if (cml_cluster_rank() == 0) {
        *range = take(work, 0, request.want, flown);
        return CML_OK;
    }
    CML_TRY(cml_cluster_request(&request, &reply, err));
    *range = (struct cml_range){reply.first, reply.count};
    return CML_OK;
}

/* Keeps the smallest overhead measured, because larger ones include delays by other work. */
void cml_work_batch_ended(struct cml_work_ranges *work, double seconds)
{
    /* twice the time for adding a tally, because clearing or gathering it costs as much again */
    const double overhead = 2 * seconds;
    if (work->overhead <= 0 || overhead < work->overhead) work->overhead = overhead;
}

/* Returns the number of packets in a piece. A piece takes 25 times the overhead, but at least a quarter of
 * the range. */
uint64_t cml_work_piece(const struct cml_work_ranges *work)
{
    const double pieces = fmin(4, target_seconds(work) / (25 * work->overhead));
    return (uint64_t)fmax(LEAST_PIECE, (double)work->want / pieces);
}

/* Returns the number of photons that no rank has taken yet. Returns 0 if there are several ranks: other ranks
 * may take these photons, so a rank is sure only of the range it holds. */
uint64_t cml_work_open_count(const struct cml_work_ranges *work)
{
    if (cml_cluster_size() > 1) return 0;
    return work->open->total < UINT64_MAX / 2 ? (uint64_t)work->open->total : UINT64_MAX / 2;
}

uint64_t cml_work_flown(struct cml_work_ranges *work)
{
    pthread_mutex_lock(&work->lock);
    const uint64_t flown = work->flown;
    pthread_mutex_unlock(&work->lock);
    return flown;
}

/* Times between a half and three halves of the target change nothing. A step is at most a factor of 4 down or
 * 8 up, so that a single disturbed range does not upset the next. */
void cml_work_timed(struct cml_work_ranges *work, struct cml_range range, double seconds)
{
    const double ratio = target_seconds(work) / fmax(seconds, 1e-9);
    if (range.count < work->want) return; /* cut short: says little about the speed */
    if (ratio > 0.67 && ratio < 2) return;
    const double want = (double)work->want * fmin(8, fmax(0.25, ratio));
    work->want = (uint64_t)fmin((double)CML_TALLY_MAX_PHOTONS, fmax(1, want));
}

/* One rank's message to rank 0 at a synchronisation. */
struct returned {
    struct cml_range left;
    uint64_t flown;
    uint64_t stop;
};

/* Adds up the messages of all ranks, on rank 0. Photons that a rank did not fly are open again, in any order.
 */
static cml_status collect(struct cml_work_ranges *work, const struct returned *all, bool *stop,
                          struct cml_error *err)
{
    for (int i = 0; i < cml_cluster_size(); i++) {
        work->flown += all[i].flown;
        *stop = *stop || all[i].stop;
        CML_TRY(cml_ranges_add(work->open, all[i].left, err));
    }
    return CML_OK;
}

/* Gathers on rank 0 what each rank has flown and left over. All ranks agree on a status before the gather,
 * because a rank without memory would leave the others waiting in it, and after it, because rank 0 may run
 * out of memory. */
cml_status cml_work_return(struct cml_work_ranges *work, struct cml_range left, uint64_t flown, bool *stop,
                           struct cml_error *err)
{
    const struct returned mine = {left, flown, *stop};
    const size_t size = cml_cluster_rank() == 0 ? (size_t)cml_cluster_size() : 1;
    CML_FREED struct returned *all = NULL;
    CML_TRY(cml_cluster_agree(cml_zeros(&all, size, sizeof *all, "what ranks give back", err), err));
    cml_status status = cml_cluster_gather(&mine, sizeof mine, all, err);
    if (status == CML_OK && cml_cluster_rank() == 0) status = collect(work, all, stop, err);
    return cml_cluster_agree(status, err);
}
