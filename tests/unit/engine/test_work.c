/* Tests of how engines take photons and deliver their tallies: every packet once, batch by batch, and no
 * thread waits for another. SPDX-License-Identifier: MIT */
#include "lib/bench.h"
#include "lib/mci_case.h"
#include "lib/sanitized.h"

#include "engine/cpu/engine_cpu.h"
#include "engine/engine_reference.h"
#include "engine/engines.h"

#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

#define BLOCK 47 /* packets of one block, all of one batch */
#define BLOCKS (2 * CML_NUM_BATCHES)
#define PACKETS (BLOCK * BLOCKS)
#define PATIENCE 120 /* s: longest time that a thread is held, reached in a failure only */

static const char *const plane = "1.0\n1\np.mco A\n1000\n0.01 0.02\n20 20 10\n2\n1.0\n"
                                 "1.4 0.5 50 0.8 0.1\n1.5 1 20 0 0.2\n1.0\n";
/* A scene with so many cells that threads share A_rz. */
static const char *const fine = "1.0\n1\np.mco A\n1000\n0.0002 0.0004\n1100 1000 10\n1\n1.0\n"
                                "1.4 0.5 50 0.8 0.1\n1.0\n";

/* Function in which the first thread to enter it is held until the other threads have flown everything
 * else. */
enum hold { NOWHERE, IN_NEXT, IN_NOTE };

/* The source of photons and the sink of tallies under test. It gives out blocks in an order in which
 * neighbouring blocks have different batches. */
struct ledger {
    pthread_mutex_t lock; /* guards all members below */
    pthread_cond_t changed;
    uint64_t most; /* packets of a piece; 0: as many as asked for */
    uint64_t given, noted;
    int times[PACKETS];
    int wrong_notes;
    enum hold hold;
    bool held, in_vain;
    uint64_t by_held;
    struct cml_result result;
};

/* Packets of each batch that this thread has taken and not yet delivered by note(). */
static _Thread_local uint64_t pending[CML_NUM_BATCHES];
static _Thread_local int calls;

static uint64_t all_pending(void)
{
    uint64_t sum = 0;
    for (int b = 0; b < CML_NUM_BATCHES; b++) sum += pending[b];
    return sum;
}

/* Stops this thread until all packets that it has not taken itself are delivered by the others. */
static void hold(struct ledger *ledger)
{
    struct timespec end;
    clock_gettime(CLOCK_REALTIME, &end);
    end.tv_sec += PATIENCE;
    ledger->hold = NOWHERE;
    ledger->held = true;
    ledger->by_held = all_pending();
    while (!ledger->in_vain && ledger->noted + all_pending() < PACKETS)
        ledger->in_vain = pthread_cond_timedwait(&ledger->changed, &ledger->lock, &end) != 0;
}

static bool next(void *context, uint64_t most, int takers, struct cml_piece *piece)
{
    struct ledger *ledger = context;
    pthread_mutex_lock(&ledger->lock);
    if (ledger->hold == IN_NEXT && ++calls == 3) hold(ledger);
    const uint64_t block = ledger->given / BLOCK, place = ledger->given % BLOCK;
    uint64_t count = cml_piece_size(most, takers, PACKETS - ledger->given);
    if (ledger->most && count > ledger->most) count = ledger->most;
    if (count > BLOCK - place) count = BLOCK - place;
    const uint64_t part = block / CML_NUM_BATCHES, batch = block * 37 % CML_NUM_BATCHES;
    *piece = (struct cml_piece){(part * BLOCK + place) * CML_NUM_BATCHES + batch, count, (int)batch};
    for (uint64_t i = 0; i < count; i++) ledger->times[piece->first + CML_NUM_BATCHES * i]++;
    ledger->given += count;
    pending[piece->batch] += count;
    pthread_mutex_unlock(&ledger->lock);
    return count > 0;
}

/* Callback of the engine: takes the tally of a batch from the thread that flew it. */
static void note(void *context, int batch, struct cml_tally *tally)
{
    struct ledger *ledger = context;
    cml_tally_sum_batch(tally, batch);
    pthread_mutex_lock(&ledger->lock);
    ledger->wrong_notes += pending[batch] == 0;
    cml_result_add_batch(&ledger->result, batch, tally);
    if (ledger->hold == IN_NOTE) hold(ledger);
    ledger->noted += pending[batch];
    pending[batch] = 0;
    pthread_cond_broadcast(&ledger->changed);
    pthread_mutex_unlock(&ledger->lock);
}

static void add(void *context, struct cml_tally *tally)
{
    struct ledger *ledger = context;
    pthread_mutex_lock(&ledger->lock);
    ledger->wrong_notes += all_pending() != 0;
    cml_result_add(&ledger->result, tally);
    cml_tally_zero(tally);
    calls = 0;
    pthread_mutex_unlock(&ledger->lock);
}

/* Source of photons that gives out a single batch. */
struct single {
    int batch; /* the next batch, given as one piece; -1: none */
    struct cml_result *result;
};

static bool next_single(void *context, uint64_t most, int takers, struct cml_piece *piece)
{
    (void)most;
    (void)takers;
    struct single *single = context;
    *piece = (struct cml_piece){0};
    if (single->batch < 0) return false;
    *piece = (struct cml_piece){(uint64_t)single->batch, PACKETS / CML_NUM_BATCHES, single->batch};
    single->batch = -1;
    return true;
}

static void note_single(void *context, int batch, struct cml_tally *tally)
{
    const struct single *single = context;
    cml_tally_sum_batch(tally, batch);
    cml_result_add_batch(single->result, batch, tally);
}

static void add_single(void *context, struct cml_tally *tally)
{
    const struct single *single = context;
    cml_result_add(single->result, tally);
    cml_tally_zero(tally);
}

static struct cml_result empty_result(const struct bench *bench)
{
    const struct cml_tally_grid grid = cml_engine_grid(bench->list.scenes, &bench->surfaces, &bench->options);
    struct cml_error err;
    struct cml_result result;
    require_ok(cml_result_create(&grid, PACKETS, &result, &err), &err);
    return result;
}

/* Flies one batch after the other, so that no packet can be counted in a wrong batch. Returns the result. */
static struct cml_result fly_by_batch(const struct bench *bench, const struct cml_engine *engine)
{
    struct cml_error err;
    struct cml_result result = empty_result(bench);
    void *self = open_engine(bench, engine);
    for (int batch = 0; batch < CML_NUM_BATCHES; batch++) {
        struct single single = {batch, &result};
        const struct cml_work work = {&single, next_single, note_single, add_single, NULL, NULL};
        require_ok(engine->run(self, &work, &err), &err);
    }
    engine->close(self);
    return result;
}

/* Compares two results to the last bit: cells of all arrays, totals and profiles of every batch, balance
 * and counts. */
static void expect_same_result(struct cml_result *a, struct cml_result *b)
{
    size_t count_a, count_b;
    const cml_u128 *cells_a = cml_result_cells(a, &count_a), *cells_b = cml_result_cells(b, &count_b);
    assert_int_equal(count_a, count_b);
    for (size_t i = 0; i < count_a; i++)
        if (cells_a[i] != cells_b[i]) fail_msg("cell %zu differs", i);
    assert_memory_equal(a->summary.balance, b->summary.balance, sizeof a->summary.balance);
    assert_memory_equal(a->summary.count, b->summary.count, sizeof a->summary.count);
}

/* Flies all packets on an engine and checks that every packet was flown once, and that the result is the
 * one of batch by batch. */
static void fly(const struct bench *bench, const struct cml_engine *engine, struct cml_result *right,
                struct ledger *ledger)
{
    struct cml_error err;
    const struct cml_work work = {ledger, next, note, add, NULL, NULL};
    ledger->result = empty_result(bench);
    pthread_mutex_init(&ledger->lock, NULL);
    pthread_cond_init(&ledger->changed, NULL);
    void *self = open_engine(bench, engine);
    require_ok(engine->run(self, &work, &err), &err);
    engine->close(self);
    for (int i = 0; i < PACKETS; i++) assert_int_equal(ledger->times[i], 1);
    assert_int_equal(ledger->noted, PACKETS);
    assert_int_equal(ledger->wrong_notes, 0);
    expect_same_result(right, &ledger->result);
    cml_result_free(&ledger->result);
    pthread_mutex_destroy(&ledger->lock);
    pthread_cond_destroy(&ledger->changed);
}

static struct bench set_up(void **state, const char *text, struct cml_result *right)
{
    struct bench bench = {.options = bench_options(5)};
    const struct cml_surface_options options = {.tessellation = {1e-2, CML_NORMALS_ANALYTIC, false}};
    struct cml_error err;
    case_read_ok(state, text, &bench.list);
    require_ok(cml_surfaces_create(bench.list.scenes, &options, &bench.surfaces, &err), &err);
    *right = fly_by_batch(&bench, cml_engine_cpu());
    return bench;
}

static void every_packet_is_flown_once_in_its_batch(void **state)
{
    static const int threads[] = {1, 2, 5, 16};
    static const uint64_t chunks[] = {0, 1, 7, 100, 100000}, most[] = {0, 3, 50};
    struct cml_result right;
    struct bench bench = set_up(state, plane, &right);
    for (int t = 0; t < 4; t++)
        for (int c = 0; c < 5; c++)
            for (int m = 0; m < 3; m++) {
                /* with sanitizers, all numbers in a quarter of their combinations */
                if (SANITIZED && (t + c + m) % 4) continue;
                struct ledger ledger = {.most = most[m]};
                bench.options.threads = threads[t];
                bench.options.chunk = chunks[c];
                fly(&bench, cml_engine_cpu(), &right, &ledger);
            }
    cml_result_free(&right);
    tear_down(&bench);
}

static void the_reference_engine_takes_the_same_work(void **state)
{
    struct cml_result of_cpu;
    struct bench bench = set_up(state, plane, &of_cpu);
    struct cml_result right = fly_by_batch(&bench, &cml_engine_reference);
    struct ledger ledger = {.most = 50};
    fly(&bench, &cml_engine_reference, &right, &ledger);
    cml_result_free(&of_cpu);
    cml_result_free(&right);
    tear_down(&bench);
}

/* A held thread keeps no other thread from its work. One grid gives each thread a copy of A_rz, the other
 * has one copy for all. */
static void a_thread_that_is_held_up_keeps_no_other_from_its_work(void **state)
{
    const char *const texts[] = {plane, fine};
    static const int threads[] = {2, 3, 8};
    for (int s = 0; s < 2; s++) {
        struct cml_result right;
        struct bench bench = set_up(state, texts[s], &right);
        for (int t = 0; t < 3; t++)
            for (enum hold where = IN_NEXT; where <= IN_NOTE; where++) {
                struct ledger ledger = {.most = 20, .hold = where};
                bench.options.threads = threads[t];
                fly(&bench, cml_engine_cpu(), &right, &ledger);
                assert_true(ledger.held);
                assert_false(ledger.in_vain);
                assert_in_range(ledger.by_held, 1, PACKETS / 2);
            }
        cml_result_free(&right);
        tear_down(&bench);
    }
}

/* A scene whose packets are totally reflected below the flank of a cone, 1e7 times before each counts as
 * lost. */
static const char *const stuck = "1.0\n1\ns.mco A\n1000\nbeam pencil at=0.05,0\n0.01 0.01\n1 1 1\n1\n1\n"
                                 "b 2 0.17320508075688773 0.1 0 0\n2 1e-30 0 0 0.5\n1\n";

/* Gives out one piece of practically endless packets, for a run that is to stop. */
static bool next_of_many(void *context, uint64_t most, int takers, struct cml_piece *piece)
{
    (void)takers;
    atomic_int *pieces = context;
    *piece = (struct cml_piece){0};
    if (atomic_fetch_add(pieces, 1) > 0) return false;
    *piece = (struct cml_piece){.first = 0, .count = most < 1000 ? most : 1000, .batch = 0};
    return true;
}

static void ignore_batch(void *context, int batch, struct cml_tally *tally)
{
    (void)context;
    (void)batch;
    (void)tally;
}

static void add_nothing(void *context, struct cml_tally *tally)
{
    (void)context;
    cml_tally_zero(tally);
}

static bool stops_now(void *context)
{
    (void)context;
    return true;
}

/* Runs every available engine and expects this status. */
static void expect_run_to_end_with(const struct bench *bench, cml_status expected)
{
    static const char *const names[] = {"cpu", "reference", "opencl"};
    for (int i = 0; i < 3; i++) {
        const struct cml_engine *engine = cml_engine_find(names[i]);
        struct cml_error err;
        atomic_int pieces = 0;
        const struct cml_work work = {&pieces, next_of_many, ignore_batch, add_nothing, NULL, stops_now};
        void *self;
        const cml_status opened =
            engine->open(bench->list.scenes, &bench->surfaces, &bench->options, &self, &err);
        if (opened == CML_E_DEVICE) continue;
        require_ok(opened, &err);
        assert_int_equal(engine->run(self, &work, &err), expected);
        engine->close(self);
    }
}

/* When a run is to stop, engines give up packets that never end. Packets of any other scene are flown to
 * their ends. */
static void packets_without_end_are_given_up_when_the_run_is_to_stop(void **state)
{
    const struct cml_surface_options options = {.force = CML_SURFACE_AUTO};
    const char *const texts[] = {stuck, plane};
    for (int s = 0; s < 2; s++) {
        struct bench bench = {.options = bench_options(5)};
        struct cml_error err;
        case_read_ok(state, texts[s], &bench.list);
        require_ok(cml_surfaces_create(bench.list.scenes, &options, &bench.surfaces, &err), &err);
        bench.options.threads = 2;
        expect_run_to_end_with(&bench, s == 0 ? CML_E_STOPPED : CML_OK);
        tear_down(&bench);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_packet_is_flown_once_in_its_batch, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(the_reference_engine_takes_the_same_work, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(a_thread_that_is_held_up_keeps_no_other_from_its_work, case_setup,
                                        case_teardown),
        cmocka_unit_test_setup_teardown(packets_without_end_are_given_up_when_the_run_is_to_stop, case_setup,
                                        case_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
