/* SPDX-License-Identifier: MIT */
#include "run/run.h"

#include "run/checkpoint.h"
#include "base/clock.h"
#include "run/cluster/cluster.h"
#include "run/saved_ranks.h"
#include "run/work_ranges.h"
#include "run/stop.h"
#include "tally/deal.h"
#include "tally/target_error.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Returns the processor time of all threads of this process, s. */
static double processor_seconds(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

/* Rank 0's decision at a synchronisation. */
enum next_step { CONTINUE, FINISHED, STOPPED };

/* The range in hand: photons that this rank took from rank 0 and flies. Threads take pieces of it. */
struct hand {
    /* held around the range, and `work` and `report` of the flight, while the engine runs */
    pthread_mutex_t lock;
    struct cml_range range;  /* the range from rank 0; empty once rank 0 knows that it is flown */
    struct cml_range left;   /* the rest of the range, which threads have not taken yet */
    double replied;          /* time when the range was taken */
    uint64_t room;           /* packets that the engine's tallies can still take */
    cml_status status;       /* status of rank 0's last reply */
    struct cml_error *error; /* message that belongs to `status` */
};

/* The state of one call of cml_run on this rank. */
struct flight {
    const struct cml_run_setup *setup;
    struct cml_run_result *out;
    pthread_mutex_t result_lock; /* held around out->result while the engine runs */
    struct hand hand;
    void *engine;
    struct cml_work_ranges work;
    struct cml_run_state state; /* `open` is used on rank 0 only */
    struct cml_ranges others;   /* turns of the run's other parts, on rank 0 */
    struct cml_deal deal;       /* the beam of each photon */
    struct cml_rank_report report;
    double begin; /* time when this process began to fly */
    double due;   /* time of the next checkpoint, on rank 0 */
};

/* ---- flying ---- */

/* Limit of packets per call of the engine where one packet may count many times in a cell: a packet may cross
 * a facet again and again, or leave many marks in a cell of the fluence. 2^24 packets may each do so 500
 * times before a cell of a tally overflows. */
#define MOST_AGAIN ((uint64_t)1 << 24)

/* Returns how many packets one call of the engine may fly before its tallies are full. Calls should be few,
 * because all threads wait for each other after each one. */
static uint64_t room_of_tallies(const struct cml_tally_grid *grid)
{
    return grid->facets || grid->marks > 0 ? MOST_AGAIN : CML_TALLY_MAX_PHOTONS;
}

/* Returns how many photons of the range in hand are flown. */
static uint64_t flown_of(const struct hand *hand)
{
    return hand->range.count - hand->left.count;
}

/* Returns how many photons the final tallies contain: those of the run, or of its part. */
static uint64_t all_photons(const struct flight *flight)
{
    const struct cml_run_state *state = &flight->state;
    if (flight->setup->part.count == 0) return state->end;
    return cml_part_turns(flight->setup->part, state->begin, state->end).count;
}

/* Shows the progress that rank 0 knows, plus the photons it has just flown itself. */
static void show_progress(struct flight *flight, uint64_t just_flown)
{
    const struct cml_run_setup *setup = flight->setup;
    const struct cml_progress progress = {cml_work_flown(&flight->work) + just_flown, all_photons(flight),
                                          flight->state.seconds + cml_now() - flight->begin};
    if (setup->on_progress && cml_cluster_rank() == 0) setup->on_progress(setup->context, &progress);
}

/* Ends the range in hand: its time decides the size of the next. Others may still fly its last packets. */
static void end_range(struct flight *flight)
{
    const struct hand *hand = &flight->hand;
    if (hand->range.count == 0) return;
    cml_work_timed(&flight->work, hand->range, cml_now() - hand->replied);
    show_progress(flight, hand->range.count);
}

/* Tells rank 0 how much was flown, and takes the next range: empty if a synchronisation is requested. */
static cml_status take_range(struct flight *flight, struct cml_error *err)
{
    struct hand *hand = &flight->hand;
    const double begin = cml_now();
    struct cml_range taken = {0};
    end_range(flight);
    CML_TRY(cml_work_take(&flight->work, flown_of(hand), &taken, err));
    hand->range = hand->left = taken;
    hand->replied = cml_now();
    flight->report.asking += hand->replied - begin;
    if (taken.count > 0) flight->report.ranges++;
    return CML_OK;
}

/* True if the run must stop: it has flown longer than most_seconds, or its caller has cancelled it; or, where
 * a checkpoint keeps its photons, a signal came or ranks are recalled (cluster.h). */
static bool must_stop(const struct flight *flight)
{
    const struct cml_run_setup *setup = flight->setup;
    if (setup->most_seconds > 0 && cml_now() - flight->begin > setup->most_seconds) return true;
    if (setup->cancelled && setup->cancelled(setup->context)) return true;
    return setup->checkpoint && (cml_stop_requested() || cml_cluster_recalled());
}

/* True if a synchronisation is requested, here after a signal or, on rank 0, for a checkpoint. */
static bool must_synchronise(struct flight *flight)
{
    if (must_stop(flight))
        cml_cluster_request_stop(&flight->work.sync);
    else if (cml_now() > flight->due)
        cml_cluster_request_sync(&flight->work.sync);
    return cml_cluster_sync_requested(&flight->work.sync);
}

/* For struct cml_work: true if this rank or another one got a signal. */
static bool stops(void *context)
{
    struct flight *flight = context;
    if (must_stop(flight)) cml_cluster_request_stop(&flight->work.sync);
    return cml_cluster_stop_requested(&flight->work.sync);
}

/* True if there are packets in hand for the engine; takes the next range if the last one is used up. */
static bool find_range(struct flight *flight)
{
    struct hand *hand = &flight->hand;
    if (hand->status != CML_OK || hand->room == 0) return false;
    if (hand->range.count > 0 && must_synchronise(flight)) return false;
    if (hand->left.count == 0) hand->status = take_range(flight, hand->error);
    return hand->status == CML_OK && hand->left.count > 0;
}

/* Least size of a limited piece, packets. A range is half a second's work of all threads. Threads that ask
 * for few packets get at most a quarter of their share of the range, so that a run of slow packets stops as
 * soon as any other; but never fewer than this number. */
#define LEAST_SHARE 16

/* Cuts a piece off the range in hand. All its photons are of one batch. */
static struct cml_piece cut_piece(struct flight *flight, uint64_t most, int takers)
{
    struct hand *hand = &flight->hand;
    const uint64_t largest = cml_work_piece(&flight->work),
                   share = hand->range.count / (4 * (uint64_t)takers);
    struct cml_piece piece = cml_deal_piece_at(&flight->deal, hand->left.first);
    if (most < largest && most > share) most = share > LEAST_SHARE ? share : LEAST_SHARE;
    uint64_t count = cml_piece_size(most < largest ? most : largest, takers,
                                    hand->left.count + cml_work_open_count(&flight->work));
    if (count > hand->left.count) count = hand->left.count;
    if (count > piece.count) count = piece.count;
    if (count > hand->room) count = hand->room;
    piece.count = count;
    hand->left.first += count;
    hand->left.count -= count;
    hand->room -= count;
    flight->report.photons += count;
    return piece;
}

/* For struct cml_work: gives a thread its next piece. The thread that finds the range used up asks rank 0 for
 * another; only threads that need packets then wait. */
static bool next_piece(void *context, uint64_t most, int takers, struct cml_piece *piece)
{
    struct flight *flight = context;
    *piece = (struct cml_piece){0};
    pthread_mutex_lock(&flight->hand.lock);
    const bool found = find_range(flight);
    if (found) *piece = cut_piece(flight, most, takers);
    pthread_mutex_unlock(&flight->hand.lock);
    return found;
}

/* For struct cml_work: adds the profiles of a finished batch to the result. The sums over the thread's own
 * tally take long, so they run outside of the lock. */
static void end_batch(void *context, int batch, struct cml_tally *tally)
{
    struct flight *flight = context;
    const double begin = cml_now();
    cml_tally_sum_batch(tally, batch);
    pthread_mutex_lock(&flight->result_lock);
    cml_result_add_batch(&flight->out->result, batch, tally);
    pthread_mutex_unlock(&flight->result_lock);
    const double seconds = cml_now() - begin;
    pthread_mutex_lock(&flight->hand.lock);
    cml_work_batch_ended(&flight->work, seconds);
    pthread_mutex_unlock(&flight->hand.lock);
}

/* For struct cml_work: adds a thread's tally to the result and clears the tally. */
static void add_tally(void *context, struct cml_tally *tally)
{
    struct flight *flight = context;
    pthread_mutex_lock(&flight->result_lock);
    cml_result_add(&flight->out->result, tally);
    pthread_mutex_unlock(&flight->result_lock);
    cml_tally_zero(tally);
}

/* For struct cml_saved_taker: takes saved packets into the result. */
static void take_saved(void *context, const void *rows, size_t count)
{
    struct flight *flight = context;
    pthread_mutex_lock(&flight->result_lock);
    cml_saved_add(flight->out->result.saved, rows, count);
    pthread_mutex_unlock(&flight->result_lock);
}

/* For struct cml_work: notes that the system started fewer threads than asked for. */
static void note_fewer_threads(void *context, int threads)
{
    struct flight *flight = context;
    const struct cml_run_setup *setup = flight->setup;
    char text[80];
    snprintf(text, sizeof text, "%d of %d threads: the system starts no more", threads,
             flight->out->timing.threads);
    if (setup->on_note && threads < flight->out->timing.threads) setup->on_note(setup->context, text);
    flight->out->timing.threads = threads;
}

/* Fails with CML_E_STOPPED: the flight was cancelled, or took longer than most_seconds. */
static cml_status fail_late(const struct cml_run_setup *setup, struct cml_error *err)
{
    if (setup->cancelled && setup->cancelled(setup->context))
        return cml_fail(err, CML_E_STOPPED, "%s: cancelled", setup->scene->output);
    return cml_fail(err, CML_E_STOPPED,
                    "%s: packets hardly end: %llu were not flown in %g s (plan --photons waits for them)",
                    setup->scene->output, (unsigned long long)setup->photons, setup->most_seconds);
}

/* Fails with CML_E_STOPPED after the engine gave up packets. No tally knows which part of it belongs to these
 * packets, so nothing of this flight counts, and the checkpoint stays unchanged. */
static cml_status fail_given_up(const struct flight *flight, struct cml_error *err)
{
    if (!flight->setup->checkpoint) return fail_late(flight->setup, err);
    return cml_fail(err, CML_E_STOPPED,
                    "%s: stopped; some packets would not end, so all that flew since the last checkpoint is "
                    "lost; --resume continues from %s, or begins anew without that file",
                    flight->setup->scene->output, flight->setup->checkpoint);
}

/* Lets the engine fly until a synchronisation is requested; calls it again only when its tallies were full.
 * hand.left is then the rest of the last range. */
static cml_status fly(struct flight *flight, struct cml_error *err)
{
    struct hand *hand = &flight->hand;
    const struct cml_work work = {flight, next_piece, end_batch, add_tally, note_fewer_threads, stops};
    const double begin = cml_now(), asking = flight->report.asking;
    hand->status = CML_OK;
    hand->error = err;
    do {
        hand->room = room_of_tallies(&flight->out->result.grid);
        const cml_status status = flight->setup->engine->run(flight->engine, &work, err);
        if (status == CML_E_STOPPED) return fail_given_up(flight, err);
        CML_TRY(status);
    } while (hand->status == CML_OK && hand->room == 0);
    flight->report.flying += cml_now() - begin - (flight->report.asking - asking);
    return hand->status;
}

/* ---- synchronisations ---- */

/* Writes a checkpoint. The turns of other parts are stored as open, like those of this part that are not
 * flown. */
static cml_status write_state(const struct flight *flight, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    struct cml_run_state state = flight->state;
    state.open = (struct cml_ranges){0};
    state.part = setup->part;
    state.seconds += cml_now() - flight->begin;
    cml_status status = cml_ranges_add_all(&state.open, &flight->others, err);
    if (status == CML_OK) status = cml_ranges_add_all(&state.open, &flight->state.open, err);
    if (status == CML_OK)
        status = cml_checkpoint_write(setup->checkpoint, setup->identity, setup->call, &state,
                                      &flight->out->result, err);
    cml_ranges_clear(&state.open);
    return status;
}

/* Writes a checkpoint, and sets when the next is due. needed: a failure ends the run; otherwise it is only
 * noted, since the next attempt may succeed. */
static cml_status write_checkpoint(struct flight *flight, bool needed, double begin, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    cml_status status = write_state(flight, err);
    if (status != CML_OK && !needed) {
        if (setup->on_note) setup->on_note(setup->context, err->text);
        status = CML_OK;
    }
    flight->due = cml_now() + fmax(setup->interval, 20 * (cml_now() - begin));
    return status;
}

/* Begins the next round of --target-error if one is needed: as many photons as all rounds before together. */
static cml_status begin_round(struct flight *flight, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    struct cml_result *result = &flight->out->result;
    struct cml_run_state *state = &flight->state;
    const bool full = state->end > ((uint64_t)1 << 47);
    if (setup->target_error <= 0 || full || cml_target_met(result, setup->target_error, setup->error_of))
        return CML_OK;
    state->begin = state->end;
    state->end = 2 * state->end;
    result->photons = state->end;
    return cml_ranges_add(&state->open, (struct cml_range){state->begin, state->end - state->begin}, err);
}

/* Decides on rank 0, with the sums of all ranks, how the run goes on; writes a due checkpoint. */
static cml_status decide(struct flight *flight, bool stop, double begin, enum next_step *next,
                         struct cml_error *err)
{
    *next = stop ? STOPPED : CONTINUE;
    if (flight->state.open.total == 0) CML_TRY(begin_round(flight, err));
    const bool complete = flight->state.open.total == 0;
    if (complete) *next = FINISHED;
    const bool part = flight->setup->part.count > 0, whole = part || flight->setup->options.rows.count > 0;
    if (flight->setup->checkpoint && (complete ? whole : stop || cml_now() > flight->due))
        return write_checkpoint(flight, stop || (complete && part), begin, err);
    return CML_OK;
}

/* Sends rank 0's round and decision to all ranks. */
static cml_status share_decision(struct flight *flight, enum next_step *next, struct cml_error *err)
{
    uint64_t word[3] = {flight->state.begin, flight->state.end, (uint64_t)*next};
    CML_TRY(cml_cluster_share(word, sizeof word, err));
    flight->state.begin = word[0];
    flight->state.end = word[1];
    *next = (enum next_step)word[2];
    return cml_deal_round(&flight->deal, word[0], word[1], err);
}

/* Brings all ranks together: photons not flown go back, the results are summed, and rank 0 decides how to go
 * on. mine: the status of this rank; a failure of any rank ends the run on all. */
static cml_status synchronise(struct flight *flight, cml_status mine, enum next_step *next,
                              struct cml_error *err)
{
    struct hand *hand = &flight->hand;
    const double begin = cml_now();
    CML_TRY(cml_cluster_synchronise(&flight->work.sync, err));
    const double all_here = cml_now();
    flight->report.waiting += all_here - begin;
    CML_TRY(cml_cluster_agree(mine, err));
    bool stop = must_stop(flight);
    CML_TRY(cml_work_return(&flight->work, hand->left, flown_of(hand), &stop, err));
    hand->range = hand->left = (struct cml_range){0};
    CML_TRY(cml_cluster_sum(&flight->out->result, err));
    CML_TRY(cml_gather_saved(flight->out->result.saved, err));
    const bool decides = cml_cluster_rank() == 0;
    CML_TRY(cml_cluster_agree(decides ? decide(flight, stop, all_here, next, err) : CML_OK, err));
    CML_TRY(share_decision(flight, next, err));
    flight->report.summing += cml_now() - all_here;
    return CML_OK;
}

/* Flies packets until the run ends. Ranks meet at times, and rank 0 decides how to go on. */
static cml_status fly_all(struct flight *flight, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    enum next_step next = CONTINUE;
    while (next == CONTINUE) {
        const cml_status status = fly(flight, err);
        CML_TRY(synchronise(flight, status, &next, err));
        show_progress(flight, 0);
    }
    if (next == FINISHED) return CML_OK;
    if (!setup->checkpoint) return fail_late(setup, err);
    return cml_fail(err, CML_E_STOPPED,
                    "%s: stopped with %llu of %llu packets to fly; --resume continues from %s",
                    setup->scene->output, (unsigned long long)flight->state.open.total,
                    (unsigned long long)all_photons(flight), setup->checkpoint);
}

/* ---- beginning and end ---- */

/* Returns the photons of the first round: `photons`, rounded up to whole batches with --target-error. */
static uint64_t first_round(const struct cml_run_setup *setup)
{
    if (setup->target_error <= 0) return setup->photons;
    return (setup->photons + CML_NUM_BATCHES - 1) / CML_NUM_BATCHES * CML_NUM_BATCHES;
}

/* True if a round of this run ends with photon end - 1. */
static bool ends_round(const struct cml_run_setup *setup, uint64_t end)
{
    uint64_t end_of_round = first_round(setup);
    while (setup->target_error > 0 && end_of_round < end) end_of_round *= 2;
    return end_of_round == end;
}

/* Notes that the checkpoint is of a finished run, but a file of its result was taken away. */
static void note_lost_result(const struct cml_run_setup *setup, enum cml_run_intent intent)
{
    const char *slash = strrchr(setup->gone, '/');
    char text[512];
    if (!setup->on_note) return;
    snprintf(text, sizeof text, "%.200s is of a finished run, but its result %.200s %s: it %s",
             setup->checkpoint, slash ? slash + 1 : setup->gone, setup->how_gone,
             intent == CML_RUN_REPUBLISH ? "is written again" : "begins anew");
    setup->on_note(setup->context, text);
}

/* True if a checkpoint with the identity of the run is of the same part, or if neither is a part. */
static bool is_same_part(const struct cml_run_setup *setup, const struct cml_run_state *state)
{
    const struct cml_part *part = &setup->part;
    return state->part.number == part->number && state->part.count == part->count &&
           (part->count == 0 || state->begin == setup->base);
}

/* Decides on rank 0 what the run has to do, and reads the checkpoint where --resume asks for one. */
static cml_status restore(struct flight *flight, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    struct cml_run_findings found = {.extends =
                                         setup->base > 0 && setup->checkpoint && setup->part.count == 0,
                                     .resumes = setup->resume,
                                     .result_gone = setup->gone != NULL,
                                     .result_stands = setup->result_stands};
    struct cml_error note = {CML_OK, ""};
    if (setup->gone) found.tallies = cml_checkpoint_look(setup->checkpoint).tallies;
    if (setup->resume && setup->checkpoint)
        CML_TRY(cml_checkpoint_read(setup->checkpoint, setup->identity, &found.kind, &flight->state,
                                    &flight->out->result, found.tallies, &flight->out->record, &note, err));
    if (found.kind == CML_CHECKPOINT_PARTIAL && !ends_round(setup, flight->state.end))
        return cml_fail(err, CML_E_INPUT, "%s: the checkpoint is damaged (%llu photons in a run of %llu)",
                        setup->checkpoint, (unsigned long long)flight->state.end,
                        (unsigned long long)setup->photons);
    if (found.kind == CML_CHECKPOINT_PARTIAL && !is_same_part(setup, &flight->state))
        return cml_fail(
            err, CML_E_INPUT, "%s: is another part of the run (expected part %llu of %llu, or no --resume)",
            setup->checkpoint, (unsigned long long)setup->part.number, (unsigned long long)setup->part.count);
    if (note.text[0] && setup->on_note) setup->on_note(setup->context, note.text);
    flight->out->intent = cml_run_intent_of(&found);
    flight->out->result.photons = flight->state.end;
    if (found.kind == CML_CHECKPOINT_FINISHED && found.result_gone)
        note_lost_result(setup, flight->out->intent);
    return CML_OK;
}

cml_status cml_run_read_base(const struct cml_run_setup *setup, struct cml_run_state *state,
                             struct cml_result *result, struct cml_error *err)
{
    enum cml_checkpoint_kind kind = CML_CHECKPOINT_NONE;
    CML_AT_END(cml_record_clear) struct cml_record before = {0};
    struct cml_error note;
    CML_TRY(cml_checkpoint_read(setup->checkpoint, setup->base_identity, &kind, state, result, true, &before,
                                &note, err));
    if (kind == CML_CHECKPOINT_NONE || state->end != setup->base || state->open.total > 0)
        return cml_fail(err, CML_E_INPUT, "%s: is not of the run to be extended", setup->checkpoint);
    return CML_OK;
}

/* On rank 0, for --more: takes the finished run as the first round, and the new photons as the next. A
 * photon's point within its batch does not depend on the number of photons (kernels/balance.h), so the old
 * tallies stay valid. The checkpoint is written at once: --resume then knows that the extension has begun. */
static cml_status begin_after_base(struct flight *flight, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    struct cml_run_state *state = &flight->state;
    struct cml_result *result = &flight->out->result;
    CML_TRY(cml_run_read_base(setup, state, result, err));
    state->begin = setup->base;
    state->end = result->photons = setup->photons;
    CML_TRY(cml_deal_round(&flight->deal, state->begin, state->end, err));
    CML_TRY(cml_ranges_add(&state->open, (struct cml_range){state->begin, state->end - state->begin}, err));
    return cml_checkpoint_write(setup->checkpoint, setup->identity, NULL, state, result, err);
}

/* Sets on rank 0 which photons are to be flown: all, the rest of a checkpoint, or those of a part. */
static cml_status begin_state(struct flight *flight, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    CML_TRY(restore(flight, err));
    if (flight->out->intent == CML_RUN_EXTEND) return begin_after_base(flight, err);
    struct cml_run_state *state = &flight->state;
    if (flight->out->intent == CML_RUN_FRESH) {
        state->begin = setup->base; /* photons of the run that is extended; else 0 */
        state->end = flight->out->result.photons = first_round(setup);
        CML_TRY(
            cml_ranges_add(&state->open, (struct cml_range){state->begin, state->end - state->begin}, err));
    }
    const struct cml_range mine = cml_part_turns(setup->part, state->begin, state->end);
    if (setup->part.count > 0) CML_TRY(cml_ranges_keep(&state->open, mine, &flight->others, err));
    if (setup->part.count > 0 && flight->out->intent == CML_RUN_RESUME && state->open.total == 0)
        flight->out->intent = CML_RUN_NOTHING_LEFT;
    return CML_OK;
}

/* Does all that may fail on one rank alone. All ranks agree on the outcome in run_flight. */
static cml_status open_flight(struct flight *flight, const struct cml_tally_grid *grid, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    CML_TRY(cml_result_create(grid, setup->photons, &flight->out->result, err));
    CML_TRY(cml_deal_create(setup->scene->shares, setup->scene->num_beams, &flight->deal, err));
    struct cml_engine_options options = setup->options;
    options.saved = (struct cml_saved_taker){take_saved, flight};
    CML_TRY(setup->engine->open(setup->scene, setup->surfaces, &options, &flight->engine, err));
    flight->out->timing.threads = setup->engine->threads(flight->engine);
    CML_TRY(cml_work_open(&flight->work, &flight->state.open, err));
    return cml_cluster_rank() == 0 ? begin_state(flight, err) : CML_OK;
}

/* Gathers how each rank spent its time, for --verbose and --json. */
static cml_status gather_reports(struct flight *flight, struct cml_error *err)
{
    struct cml_run_result *out = flight->out;
    struct cml_timing *timing = &out->timing;
    timing->ranks = cml_cluster_size();
    CML_TRY(cml_cluster_agree(
        cml_zeros(&timing->rank, (size_t)timing->ranks, sizeof *timing->rank, "the ranks", err), err));
    flight->report.elapsed = cml_now() - flight->begin;
    flight->report.processor = processor_seconds() - flight->report.processor;
    timing->seconds = flight->state.seconds + flight->report.elapsed;
    out->state = (struct cml_run_state){
        .begin = flight->state.begin, .end = flight->state.end, .seconds = timing->seconds};
    return cml_cluster_gather(&flight->report, sizeof flight->report, timing->rank, err);
}

/* Flies, if all ranks are ready. No rank may leave between the agreement on `ready` and the last
 * synchronisation: the others would wait for it. Failures are therefore carried to the next synchronisation
 * and agreed on there. */
static cml_status run_flight(struct flight *flight, cml_status ready, struct cml_error *err)
{
    enum next_step next = flight->out->intent == CML_RUN_NOTHING_LEFT ? FINISHED : CONTINUE;
    CML_TRY(cml_cluster_agree(ready, err));
    CML_TRY(share_decision(flight, &next, err));
    if (next == FINISHED) {
        flight->out->intent = CML_RUN_NOTHING_LEFT; /* other ranks did not know */
        return CML_OK;
    }
    flight->work.flown = all_photons(flight) - flight->state.open.total;
    flight->begin = cml_now();
    flight->report.processor = processor_seconds();
    flight->due = cml_cluster_rank() == 0 && flight->setup->checkpoint && flight->setup->interval > 0
                      ? flight->begin + flight->setup->interval
                      : INFINITY;
    CML_TRY(fly_all(flight, err));
    return gather_reports(flight, err);
}

/* Clears all members first, so that every step may fail: closing what is zero does nothing. */
cml_status cml_run(const struct cml_run_setup *setup, struct cml_run_result *out, struct cml_error *err)
{
    const struct cml_tally_grid grid = cml_run_grid(setup);
    struct flight flight = {.setup = setup, .out = out};
    *out = (struct cml_run_result){0};
    pthread_mutex_init(&flight.hand.lock, NULL);
    pthread_mutex_init(&flight.result_lock, NULL);
    cml_status status = open_flight(&flight, &grid, err);
    status = run_flight(&flight, status, err);
    cml_work_close(&flight.work);
    setup->engine->close(flight.engine);
    pthread_mutex_destroy(&flight.hand.lock);
    pthread_mutex_destroy(&flight.result_lock);
    cml_ranges_clear(&flight.state.open);
    cml_ranges_clear(&flight.others);
    cml_deal_clear(&flight.deal);
    if (status != CML_OK) cml_run_result_free(out);
    return status;
}

void cml_run_result_free(struct cml_run_result *out)
{
    cml_result_free(&out->result);
    cml_record_clear(&out->record);
    free(out->timing.rank);
    *out = (struct cml_run_result){0};
}
