/* SPDX-License-Identifier: MIT */
#include "run/run.h"

#include "run/checkpoint.h"
#include "base/clock.h"
#include "run/cluster.h"
#include "run/work_ranges.h"
#include "run/stop.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

static double processor(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

enum verdict { GO_ON, DONE, STOPPED };

struct flight {
    const struct cml_run_setup *setup;
    struct cml_run_result *out;
    struct cml_tally tally; /* of the pieces that the result has not been given yet, but for their profiles */
    uint64_t in_tally;      /* packets */
    void *engine;
    struct cml_dispatch dispatch;
    struct cml_run_state state; /* `open` is rank 0's */
    struct cml_rank_report mine;
    double begin; /* of this process' flight */
    double due;   /* on rank 0: time of the next checkpoint */
};

/* ---- flying
 * ------------------------------------------------------------------------------------------------- */

/* So many packets may each cross a facet 500 times before a cell of a tally overflows. */
#define MOST_IN_TALLY ((uint64_t)1 << 24)

static void empty_tally(struct flight *flight)
{
    if (flight->in_tally == 0) return;
    cml_result_add(&flight->out->result, &flight->tally);
    cml_tally_zero(&flight->tally);
    flight->in_tally = 0;
}

static cml_status fly_piece(struct flight *flight, int batch, uint64_t first, uint64_t count,
                            struct cml_error *err)
{
    const double begin = cml_now();
    CML_TRY(flight->setup->engine->run(flight->engine, first, count, &flight->tally, err));
    cml_result_note(&flight->out->result, batch, &flight->tally);
    flight->in_tally += count;
    if (flight->in_tally >= MOST_IN_TALLY) empty_tally(flight);
    flight->mine.flying += cml_now() - begin;
    flight->mine.photons += count;
    return CML_OK;
}

/* Piece by piece, each within one batch, until the range is flown or a meeting is called. */
static cml_status fly_range(struct flight *flight, struct cml_range *range, struct cml_error *err)
{
    const uint64_t round = flight->state.end - flight->state.begin;
    while (range->count > 0 && !cml_cluster_called()) {
        const uint64_t place = range->first - flight->state.begin;
        const int batch = cml_batch_of(round, place);
        const uint64_t in_batch = cml_batch_first(round, batch + 1) - place;
        const uint64_t piece = cml_dispatch_piece(&flight->dispatch);
        uint64_t count = in_batch < range->count ? in_batch : range->count;
        if (count > piece) count = piece;
        CML_TRY(fly_piece(flight, batch, range->first, count, err));
        range->first += count;
        range->count -= count;
        if ((flight->setup->checkpoint && cml_stop_requested()) || cml_now() > flight->due)
            cml_cluster_call();
    }
    return CML_OK;
}

static void show_progress(struct flight *flight, uint64_t just_flown)
{
    const struct cml_run_setup *setup = flight->setup;
    const struct cml_progress progress = {cml_dispatch_flown(&flight->dispatch) + just_flown,
                                          flight->state.end,
                                          flight->state.seconds + cml_now() - flight->begin};
    if (setup->on_progress && cml_cluster_rank() == 0) setup->on_progress(setup->context, &progress);
}

/* Range after range until there is a reason to meet. *left is what was not flown of the last, *flown what
 * rank 0 has not been told of. */
static cml_status fly(struct flight *flight, struct cml_range *left, uint64_t *flown, struct cml_error *err)
{
    for (;;) {
        struct cml_range taken;
        const double begin = cml_now();
        CML_TRY(cml_dispatch_take(&flight->dispatch, *flown, &taken, err));
        const double answered = cml_now();
        flight->mine.asking += answered - begin;
        *flown = 0;
        if (taken.count == 0) return CML_OK;
        flight->mine.ranges++;
        *left = taken;
        CML_TRY(fly_range(flight, left, err));
        *flown = taken.count - left->count;
        if (left->count > 0) return CML_OK;
        cml_dispatch_timed(&flight->dispatch, taken, cml_now() - answered);
        show_progress(flight, *flown);
    }
}

/* ---- meetings
 * ----------------------------------------------------------------------------------------------- */

/* A failure ends a run that was asked to stop; otherwise the photons fly on, and the next attempt may
 * succeed. */
static cml_status write_checkpoint(struct flight *flight, bool stop, double begin, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    struct cml_run_state state = flight->state;
    state.seconds += cml_now() - flight->begin;
    cml_status status =
        cml_checkpoint_write(setup->checkpoint, setup->identity, &state, &flight->out->result, err);
    if (status != CML_OK && !stop) {
        if (setup->on_note) setup->on_note(setup->context, err->text);
        status = CML_OK;
    }
    flight->due = cml_now() + fmax(setup->interval, 20 * (cml_now() - begin));
    return status;
}

/* The next round where one is needed. */
static cml_status begin_round(struct flight *flight, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    struct cml_result *result = &flight->out->result;
    struct cml_run_state *state = &flight->state;
    const bool full = state->end > ((uint64_t)1 << 47);
    if (setup->target_error <= 0 || full || cml_run_error(result) <= setup->target_error) return CML_OK;
    state->begin = state->end;
    state->end = 2 * state->end;
    result->photons = state->end;
    return cml_ranges_add(&state->open, (struct cml_range){state->begin, state->end - state->begin}, err);
}

/* What rank 0 decides when it has everything. */
static cml_status decide(struct flight *flight, bool stop, double begin, enum verdict *verdict,
                         struct cml_error *err)
{
    *verdict = stop ? STOPPED : GO_ON;
    if (flight->state.open.total == 0) CML_TRY(begin_round(flight, err));
    if (flight->state.open.total == 0)
        *verdict = DONE;
    else if (flight->setup->checkpoint && (stop || cml_now() > flight->due))
        return write_checkpoint(flight, stop, begin, err);
    return CML_OK;
}

/* Rank 0's round and verdict become everyone's. */
static cml_status follow(struct flight *flight, enum verdict *verdict, struct cml_error *err)
{
    uint64_t word[3] = {flight->state.begin, flight->state.end, (uint64_t)*verdict};
    CML_TRY(cml_cluster_share(word, sizeof word, err));
    flight->state.begin = word[0];
    flight->state.end = word[1];
    *verdict = (enum verdict)word[2];
    return CML_OK;
}

static cml_status meet(struct flight *flight, cml_status mine, struct cml_range left, uint64_t flown,
                       enum verdict *verdict, struct cml_error *err)
{
    const double begin = cml_now();
    CML_TRY(cml_cluster_meet(err));
    const double met = cml_now();
    flight->mine.waiting += met - begin;
    CML_TRY(cml_cluster_agree(mine, err));
    bool stop = flight->setup->checkpoint && cml_stop_requested();
    CML_TRY(cml_dispatch_return(&flight->dispatch, left, flown, &stop, err));
    empty_tally(flight);
    CML_TRY(cml_cluster_sum(&flight->out->result, err));
    cml_status status = CML_OK;
    if (cml_cluster_rank() == 0) status = decide(flight, stop, met, verdict, err);
    CML_TRY(cml_cluster_agree(status, err));
    CML_TRY(follow(flight, verdict, err));
    flight->mine.meeting += cml_now() - met;
    return CML_OK;
}

static cml_status fly_all(struct flight *flight, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    enum verdict verdict = GO_ON;
    while (verdict == GO_ON) {
        struct cml_range left = {0};
        uint64_t flown = 0;
        const cml_status status = fly(flight, &left, &flown, err);
        if (status != CML_OK) left = (struct cml_range){0};
        CML_TRY(meet(flight, status, left, flown, &verdict, err));
        show_progress(flight, 0);
    }
    if (verdict == DONE) return CML_OK;
    return cml_fail(err, CML_E_STOPPED,
                    "%s: stopped with %llu of %llu packets to fly; --resume continues from %s",
                    setup->scene->output, (unsigned long long)flight->state.open.total,
                    (unsigned long long)flight->state.end, setup->checkpoint);
}

/* ---- beginning and end
 * -------------------------------------------------------------------------------------- */

static cml_status restore(struct flight *flight, bool *fresh, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    enum cml_checkpoint_kind kind = CML_CHECKPOINT_NONE;
    struct cml_error note = {CML_OK, ""};
    if (setup->resume)
        CML_TRY(cml_checkpoint_read(setup->checkpoint, setup->identity, &kind, &flight->state,
                                    &flight->out->result, &note, err));
    if (note.text[0] && setup->on_note) setup->on_note(setup->context, note.text);
    flight->out->finished = kind == CML_CHECKPOINT_FINISHED;
    flight->out->result.photons = flight->state.end;
    *fresh = kind == CML_CHECKPOINT_NONE;
    return CML_OK;
}

/* On rank 0: where the flight begins. */
static cml_status begin_state(struct flight *flight, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    bool fresh = true;
    CML_TRY(restore(flight, &fresh, err));
    if (!fresh) return CML_OK;
    uint64_t photons = setup->photons;
    if (setup->target_error > 0)
        photons = (photons + CML_NUM_BATCHES - 1) / CML_NUM_BATCHES * CML_NUM_BATCHES;
    flight->state.end = flight->out->result.photons = photons;
    return cml_ranges_add(&flight->state.open, (struct cml_range){0, photons}, err);
}

/* Seconds that one piece costs beyond its packets: its profiles are summed, and what threads scored apart is
 * gathered, by all of them. The first round only touches the memory. */
static double measure_overhead(struct flight *flight)
{
    double begin = 0;
    for (int round = 0; round < 2; round++) {
        begin = cml_now();
        cml_tally_zero(&flight->tally);
        cml_result_note(&flight->out->result, 0, &flight->tally);
    }
    return 2 * (cml_now() - begin);
}

static cml_status open_flight(struct flight *flight, const struct cml_grid *grid, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    CML_TRY(cml_result_create(grid, setup->photons, &flight->out->result, err));
    CML_TRY(cml_tally_create(grid, &flight->tally, err));
    CML_TRY(setup->engine->open(setup->scene, setup->surfaces, &setup->options, &flight->engine, err));
    flight->out->threads = setup->engine->threads(flight->engine);
    CML_TRY(cml_dispatch_open(&flight->dispatch, &flight->state.open, measure_overhead(flight), err));
    return cml_cluster_rank() == 0 ? begin_state(flight, err) : CML_OK;
}

static cml_status gather_reports(struct flight *flight, struct cml_error *err)
{
    struct cml_run_result *out = flight->out;
    out->ranks = cml_cluster_size();
    out->rank = calloc((size_t)out->ranks, sizeof *out->rank);
    cml_status status = CML_OK;
    if (!out->rank)
        status = cml_fail_memory(err, out->ranks * (double)sizeof *out->rank, "the ranks' reports");
    CML_TRY(cml_cluster_agree(status, err));
    flight->mine.elapsed = cml_now() - flight->begin;
    flight->mine.processor = processor() - flight->mine.processor;
    out->seconds = flight->state.seconds + flight->mine.elapsed;
    return cml_cluster_gather(&flight->mine, sizeof flight->mine, out->rank, err);
}

/* Between the agreement that everyone is ready and the last meeting nobody may leave. */
static cml_status run_flight(struct flight *flight, cml_status ready, struct cml_error *err)
{
    enum verdict verdict = flight->out->finished ? DONE : GO_ON;
    CML_TRY(cml_cluster_agree(ready, err));
    CML_TRY(follow(flight, &verdict, err));
    flight->out->finished = verdict == DONE;
    if (verdict == DONE) return CML_OK;
    flight->dispatch.flown = flight->state.end - flight->state.open.total;
    flight->begin = cml_now();
    flight->mine.processor = processor();
    flight->due = cml_cluster_rank() == 0 && flight->setup->checkpoint
                      ? flight->begin + flight->setup->interval
                      : INFINITY;
    CML_TRY(fly_all(flight, err));
    return gather_reports(flight, err);
}

cml_status cml_run(const struct cml_run_setup *setup, struct cml_run_result *out, struct cml_error *err)
{
    const struct cml_grid grid = cml_engine_grid(setup->scene, setup->surfaces, &setup->options);
    struct flight flight = {.setup = setup, .out = out};
    *out = (struct cml_run_result){0};
    cml_status status = open_flight(&flight, &grid, err);
    status = run_flight(&flight, status, err);
    cml_dispatch_close(&flight.dispatch);
    setup->engine->close(flight.engine);
    cml_tally_free(&flight.tally);
    cml_ranges_clear(&flight.state.open);
    if (status != CML_OK) cml_run_result_free(out);
    return status;
}

void cml_run_result_free(struct cml_run_result *out)
{
    cml_result_free(&out->result);
    free(out->rank);
    *out = (struct cml_run_result){0};
}

double cml_run_error(const struct cml_result *result)
{
    static const enum cml_total totals[] = {CML_TOTAL_REFLECTED, CML_TOTAL_ABSORBED, CML_TOTAL_TRANSMITTED};
    double largest = 0;
    for (size_t i = 0; i < sizeof totals / sizeof *totals; i++) {
        const double share = cml_result_total(result, totals[i]);
        if (share < CML_TARGET_LEAST_SHARE) continue;
        largest = fmax(largest, cml_result_error(result, totals[i]) / share);
    }
    return largest;
}

double cml_run_steps(const struct cml_run_result *run)
{
    const cml_u128 *count = run->result.summary.count;
    return (double)(count[CML_COUNT_INTERACTIONS] + count[CML_COUNT_BOUNDARY_EVENTS]);
}

double cml_run_processor(const struct cml_run_result *run)
{
    double seconds = 0;
    for (int i = 0; i < run->ranks; i++) seconds += run->rank[i].processor;
    return seconds;
}

double cml_run_idle(const struct cml_run_result *run)
{
    double waiting = 0, elapsed = 0;
    for (int i = 0; i < run->ranks; i++) {
        waiting += run->rank[i].waiting;
        elapsed += run->rank[i].elapsed;
    }
    return elapsed > 0 ? waiting / elapsed : 0;
}

double cml_run_communication(const struct cml_run_result *run)
{
    double spent = 0, elapsed = 0;
    for (int i = 0; i < run->ranks; i++) {
        spent += run->rank[i].asking + run->rank[i].meeting;
        elapsed += run->rank[i].elapsed;
    }
    return elapsed > 0 ? spent / elapsed : 0;
}

cml_status cml_run_verdict(const struct cml_scene *scene, const struct cml_result *result,
                           struct cml_error *err)
{
    const double residue = cml_result_imbalance(result);
    if (residue != 0)
        return cml_fail(err, CML_E_NUMERIC,
                        "%s: the energy books do not balance: residue %.17g of 2^-31 packets", scene->output,
                        residue);
    const double lost = (double)cml_result_lost(result),
                 photons = (double)result->summary.count[CML_COUNT_PHOTONS];
    if (lost > 1e-6 * photons)
        return cml_fail(err, CML_E_NUMERIC, "%s: %.0f of %.0f packets lost (at most 1 in 1e6 may be)",
                        scene->output, lost, photons);
    return CML_OK;
}

double cml_run_bytes(const struct cml_grid *grid, int threads)
{
    const struct cml_grid of_thread = cml_grid_of_thread(grid);
    return cml_result_bytes(grid) + cml_tally_bytes(grid) + threads * cml_tally_bytes(&of_thread);
}
