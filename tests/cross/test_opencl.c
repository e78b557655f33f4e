/* Compares the opencl engine with the cpu engine, packet by packet, and with itself for every division of
 * the work, on every device of the machine.
 * SPDX-License-Identifier: MIT */
#include "lib/bench.h"
#include "lib/sanitized.h"
#include "flight.h"

#include "engine/cpu/engine_cpu.h"
#include "engine/opencl/engine_opencl.h"
#include "engine/opencl/opencl.h"
#include "run/run.h"

#include <math.h>

#define HEAD "1.0\n1\nscene A\n1000\n"
#define GRID "0.01 0.02\n20 30 10\n"
static const char *const scenes[] = {
    /* planes; glass on top; heightfields, re-entry, an oblique and a wide beam; guided light; g = +-1;
     * bodies; phase functions of some media and of all */
    HEAD GRID "2\n1\n1.4 0.5 50 0.8 0.1\n1.5 1 20 0 0.2\n1\n",
    HEAD GRID "3\n1\n1.5 0 0 0 0.1\n1.4 0.5 50 0.9 0.1\n1.5 0 0 0 0.1\n1\n",
    HEAD GRID "2\n1\nb 4 0.05 0.1 0.02 0.1 0.03 0.1 0 0\n1.4 0.5 50 0.8 0.2\nb 3 -0.05 0.1 0.02 0.2 0 0\n"
              "1.5 1 20 0 0.2\nb 3 0.02 0.1 -0.02 0.1 0.01 0\n1\n",
    HEAD "beam gaussian 0.2 at=0.3,-0.1 angle=30\n" GRID
         "1\n1\nb 3 0.1 0.1 -0.1 0.2 0 0\n1.4 1 10 -1 0.5\n1.6\n",
    HEAD "beam disk 0.1\n" GRID "1\n1.4\n1.4 1 10 1 0.5\n1.4\n",
    HEAD GRID "1\n1\n1.4 0.5 50 0.8 0.5\ni sphere 0.05 0 0.1 0.06 1.5 2 10 0.5\n"
              "i cylinder -1 -0.1 0.25 1 -0.1 0.3 0.05 1.3 5 20 0.9\n1\n",
    HEAD GRID "2\n1\n1.4 0.5 50 0.62 0.1\nphase hg2 0.9 -0.5 0.8\ni sphere 0.05 0 0.05 0.03 1.5 2 10 -0.9\n"
              "phase gk -0.9 0.5\n1.5 1 20 0.5 0.2\n1\n",
    HEAD GRID "1\n1\n1.4 0.5 50 0 0.5\nphase rayleigh\n1\n",
};
enum { num_scenes = sizeof scenes / sizeof *scenes };

static char device[16]; /* number of the device under test */

/* A way to build a kernel and divide the work. */
struct way {
    const char *name;
    int group; /* work-items of a group: one, with 16 lanes, or several with one lane each, as on a GPU */
    const char *build_options;
    bool loose_division;
};

static void set_up(const char *text, struct bench *bench)
{
    struct cml_error err;
    const struct cml_surface_options surface = {.force = CML_SURFACE_AUTO,
                                                .tessellation = {.tolerance = 1e-3}};
    read_scenes(text, &bench->list);
    require_ok(cml_surfaces_create(bench->list.scenes, &surface, &bench->surfaces, &err), &err);
    bench->options = bench_options(7);
    bench->options.threads = 0;
    bench->options.device = device;
}

static void go(const struct way *way, struct bench *bench)
{
    bench->options.group = way->group;
    bench->options.build_options = way->build_options;
    bench->options.loose_division = way->loose_division;
}

/* Returns the tally of packets [first, first + count) on an engine that stays open. */
static struct cml_tally fly_range(const struct bench *bench, const struct cml_engine *engine, void *self,
                                  uint64_t first, uint64_t count)
{
    struct cml_error err;
    struct cml_tally tally = empty_tally(bench);
    require_ok(cml_engine_run_range(engine, self, first, count, &tally, &err), &err);
    return tally;
}

enum { packets = 20011 };

/* Returns how many packets of a scene end differently than on the cpu. */
static int count_differing(const struct bench *bench)
{
    static struct cml_fate_record a[packets], b[packets];
    struct cml_error err;
    int differ = 0;
    void *cpu = open_engine(bench, cml_engine_cpu()), *opencl = open_engine(bench, &cml_engine_opencl);
    require_ok(cml_engine_cpu()->fates(cpu, 77, packets, a, &err), &err);
    require_ok(cml_engine_opencl.fates(opencl, 77, packets, b, &err), &err);
    for (int i = 0; i < packets; i++)
        differ += a[i].fate != b[i].fate || a[i].interactions != b[i].interactions ||
                  a[i].boundary_events != b[i].boundary_events || a[i].weight != b[i].weight ||
                  a[i].absorbed != b[i].absorbed;
    cml_engine_cpu()->close(cpu);
    cml_engine_opencl.close(opencl);
    return differ;
}

/* True if this way is tested with this scene. Compiling a kernel for each way and each combination of
 * shapes, bodies and phase functions takes most of the test's time.
 *
 * Unless all cases are asked for, no kernel is compiled for bodies alone, phase functions alone, words alone
 * or loose division, and groups fly heightfields (2) only. */
static bool is_flown(const struct way *way, int scene)
{
    const bool all = cases_step() == 1, both = scene == 2 || scene == 6;
    if (way->loose_division) return all && both;
    return all || (way->group ? scene == 2 : scene != 5 && scene != 7);
}

static void compare_fates(const struct way *way)
{
    for (int s = 0; s < num_scenes; s++) {
        struct bench bench;
        if (!is_flown(way, s)) continue;
        set_up(scenes[s], &bench);
        go(way, &bench);
        const int differ = count_differing(&bench);
        printf("device %s, %s, scene %d: %d of %d packets differ\n", device, way->name, s, differ,
               (int)packets);
        assert_true(differ * 10000 <= packets);
        tear_down(&bench);
    }
}

static void fates_are_those_of_the_cpu(void **state)
{
    (void)state;
    const struct way chosen = {"as chosen", 0, NULL, false}, groups = {"groups", 32, NULL, false},
                     poor = {"groups, words, loose division", 32, "-D CML_TWO_WORDS", true};
    compare_fates(&chosen);
    compare_fates(&groups);
    compare_fates(&poor);
}

/* Returns the share of weight that lies in another cell than on the cpu: packets that differ, and packets
 * that rounding has put beyond the edge of a bin. */
static double share_elsewhere(const struct cml_tally *a, const struct cml_tally *b)
{
    const uint64_t cells = cml_tally_cells(&a->grid);
    double all = 0, elsewhere = 0;
    for (uint64_t i = 0; i < cells; i++) {
        all += (double)a->A_l[i];
        elsewhere += fabs((double)a->A_l[i] - (double)b->A_l[i]);
    }
    return elsewhere / all;
}

static void tallies_are_those_of_the_cpu(void **state)
{
    (void)state;
    static const struct way ways[] = {{"as chosen", 0, NULL, false}, {"groups", 32, NULL, false}};
    for (size_t w = 0; w < sizeof ways / sizeof *ways; w++)
        for (int s = 0; s < num_scenes; s++) {
            struct bench bench;
            if (!is_flown(&ways[w], s)) continue;
            set_up(scenes[s], &bench);
            go(&ways[w], &bench);
            void *cpu = open_engine(&bench, cml_engine_cpu()),
                 *self = open_engine(&bench, &cml_engine_opencl);
            struct cml_tally a = fly_range(&bench, cml_engine_cpu(), cpu, 77, packets),
                             b = fly_range(&bench, &cml_engine_opencl, self, 77, packets);
            const double elsewhere = share_elsewhere(&a, &b);
            if (elsewhere > 1e-3)
                fail_msg("device %s, %s, scene %d: %g of the weight lies elsewhere", device, ways[w].name, s,
                         elsewhere);
            cml_tally_free(&a);
            cml_tally_free(&b);
            cml_engine_cpu()->close(cpu);
            cml_engine_opencl.close(self);
            tear_down(&bench);
        }
}

/* The engine's records of a range add up to its tally of that range. */
static void records_add_up_to_the_tally(void **state)
{
    (void)state;
    enum { few = 3001 };
    static struct cml_fate_record records[few];
    struct bench bench;
    struct cml_error err;
    uint64_t interactions = 0, reflected = 0, absorbed = 0;
    set_up(scenes[2], &bench);
    void *self = open_engine(&bench, &cml_engine_opencl);
    require_ok(cml_engine_opencl.fates(self, 5, few, records, &err), &err);
    struct cml_tally tally = fly_range(&bench, &cml_engine_opencl, self, 5, few);
    for (int i = 0; i < few; i++) {
        const uint64_t units = (uint64_t)(records[i].absorbed * 2147483648.0);
        interactions += records[i].interactions;
        absorbed += units;
        if (records[i].fate == 2) reflected += records[i].weight; /* the value of CML_FATE_REFLECTED */
    }
    assert_true(interactions == tally.count[CML_COUNT_INTERACTIONS]);
    assert_true(reflected == tally.balance[CML_BALANCE_REFLECTED] && reflected > 0);
    assert_true(absorbed == tally.balance[CML_BALANCE_ABSORBED]);
    cml_tally_free(&tally);
    cml_engine_opencl.close(self);
    tear_down(&bench);
}

/* Tests one packet, none, numbers that are multiples of no group size, and indices beyond 2^32. */
static void any_number_of_packets_balances(void **state)
{
    (void)state;
    static const uint64_t counts[] = {0, 1, 2, 3, 31, 127, 129, 1009, 10007};
    for (int s = 0; s < 3; s++) {
        struct bench bench;
        set_up(scenes[s], &bench);
        void *self = open_engine(&bench, &cml_engine_opencl);
        for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
            struct cml_tally tally =
                fly_range(&bench, &cml_engine_opencl, self, ((uint64_t)1 << 33) - 5, counts[i]);
            if (counts[i]) assert_weight_balances(&tally, counts[i]);
            assert_true(tally.count[CML_COUNT_PHOTONS] == counts[i]);
            cml_tally_free(&tally);
        }
        cml_engine_opencl.close(self);
        tear_down(&bench);
    }
}

/* Tests that groups with shared local memory, 32-bit words with carry, several devices, and chunks give the
 * same bits. */
static void division_of_work_does_not_change_a_bit(void **state)
{
    (void)state;
    static const struct {
        struct way way;
        int times; /* number of times that the device is named */
        uint64_t chunk;
    } ways[] = {
        {{"chunks", 0, NULL, false}, 1, 1000},
        {{"a device twice", 0, NULL, false}, 2, 0},
        {{"a device three times", 0, NULL, false}, 3, 7},
        {{"words", 0, "-D CML_TWO_WORDS", false}, 1, 0},
        {{"groups", 32, NULL, false}, 1, 0},
        {{"groups and words", 32, "-D CML_TWO_WORDS", false}, 2, 0},
    };
    struct bench bench;
    set_up(scenes[2], &bench);
    bench.options.group = 1;
    void *self = open_engine(&bench, &cml_engine_opencl);
    struct cml_tally one = fly_range(&bench, &cml_engine_opencl, self, 3, 9001);
    cml_engine_opencl.close(self);
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        char devices[3 * sizeof device + 3];
        if (ways[i].way.build_options && !ways[i].way.group && cases_step() > 1)
            continue; /* a case for
                       * words alone */
        snprintf(devices, sizeof devices, "%s,%s,%s", device, device, device);
        devices[(size_t)ways[i].times * (strlen(device) + 1) - 1] = '\0';
        go(&ways[i].way, &bench);
        bench.options.device = devices;
        bench.options.chunk = ways[i].chunk;
        self = open_engine(&bench, &cml_engine_opencl);
        struct cml_tally other = fly_range(&bench, &cml_engine_opencl, self, 3, 9001);
        expect_same(&one, &other, ways[i].way.name);
        cml_tally_free(&other);
        cml_engine_opencl.close(self);
    }
    cml_tally_free(&one);
    tear_down(&bench);
}

struct events {
    int count;
    char what[4096];
};

static void note_event(void *context, const struct cml_trace_event *event)
{
    struct events *events = context;
    if (events->count < (int)sizeof events->what - 1) events->what[events->count++] = event->what[0];
    events->what[events->count] = '\0';
}

/* Returns how many of 20 packets have a different trace. */
static int count_differing_traces(int group)
{
    static struct events a, b;
    struct bench bench;
    struct cml_error err;
    struct cml_fate_record ra, rb;
    set_up(scenes[2], &bench);
    bench.options.group = group;
    void *cpu = open_engine(&bench, cml_engine_cpu()), *opencl = open_engine(&bench, &cml_engine_opencl);
    int differ = 0;
    for (uint64_t index = 0; index < 20; index++) {
        a.count = b.count = 0;
        require_ok(cml_engine_cpu()->trace(cpu, index, note_event, &a, &ra, &err), &err);
        require_ok(cml_engine_opencl.trace(opencl, index, note_event, &b, &rb, &err), &err);
        differ += strcmp(a.what, b.what) != 0 || ra.fate != rb.fate || ra.weight != rb.weight;
    }
    cml_engine_cpu()->close(cpu);
    cml_engine_opencl.close(opencl);
    tear_down(&bench);
    return differ;
}

static void a_trace_shows_the_events_of_the_cpu(void **state)
{
    (void)state;
    assert_true(count_differing_traces(0) <= 1);
    assert_true(count_differing_traces(32) <= 1);
}

static void ranks_of_a_machine_go_round_its_gpus(void **state)
{
    (void)state;
    const struct cml_opencl_info mixed[] = {
        {.type = "CPU"}, {.type = "GPU"}, {.type = "other"}, {.type = "GPU"}};
    static const int wanted[] = {1, 3, 1, 3, 1}, round[] = {0, 1, 0, 1, 0};
    const struct cml_opencl_info none[] = {{.type = "CPU"}, {.type = "other"}};
    for (int rank = 0; rank < 5; rank++) {
        assert_int_equal(cml_opencl_default(mixed, 4, rank), wanted[rank]);
        assert_int_equal(cml_opencl_default(none, 2, rank), round[rank]);
    }
}

static int count_devices(void)
{
    struct cml_opencl_info *list;
    struct cml_error err;
    int count = 0;
    if (cml_opencl_list(&list, &count, &err) == CML_OK) free(list);
    return count;
}

int main(void)
{
    const struct CMUnitTest of_a_device[] = {
        cmocka_unit_test(fates_are_those_of_the_cpu),
        cmocka_unit_test(tallies_are_those_of_the_cpu),
        cmocka_unit_test(records_add_up_to_the_tally),
        cmocka_unit_test(any_number_of_packets_balances),
        cmocka_unit_test(division_of_work_does_not_change_a_bit),
        cmocka_unit_test(a_trace_shows_the_events_of_the_cpu),
    };
    const struct CMUnitTest of_none[] = {cmocka_unit_test(ranks_of_a_machine_go_round_its_gpus)};
    const int devices = count_devices();
    int failed = cmocka_run_group_tests(of_none, NULL, NULL);
    for (int i = 0; i < devices; i++) {
        snprintf(device, sizeof device, "%d", i);
        failed += cmocka_run_group_tests(of_a_device, NULL, NULL);
    }
    return failed ? 1 : (devices ? 0 : 77);
}
