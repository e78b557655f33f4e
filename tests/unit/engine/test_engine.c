/* Tests of properties that all engines share: threads, chunks, ranges and the unit of length must not
 * change a result. SPDX-License-Identifier: MIT */
#include "lib/bench.h"
#include "lib/mci_case.h"
#include "lib/sanitized.h"

#include "engine/cpu/engine_cpu.h"
#include "engine/engine_reference.h"
#include "run/run.h"
#include "types.h"

#include <math.h>

#define PACKETS 20000

static const char *const planes = "1.0\n1\np.mco A\n1000\n0.01 0.02\n20 20 10\n2\n1.0\n"
                                  "1.4 0.5 50 0.8 0.1\n1.5 1 20 0 0.2\n1.0\n";
static const char *const hills = "1.0\n1\nh.mco A\n1000\n0.01 0.02\n20 20 10\n2\n1.0\n"
                                 "b 4 0.05 0.1 0.02 0.1 0.03 0.1 0 0\n1.4 0.5 50 0.8 0.2\n"
                                 "b 3 -0.05 0.1 0.02 0.2 0 0\n1.5 1 20 0 0.2\n"
                                 "b 3 0.02 0.1 -0.02 0.1 0.01 0\n1.0\n";
static const char *const glass = "1.0\n1\ng.mco A\n1000\n0.01 0.02\n20 20 10\n3\n1.0\n"
                                 "1.5 0 0 0 0.1\n1.4 0.5 50 0.9 0.1\n1.5 0 0 0 0.1\n1.0\n";

static void represent(struct bench *bench, enum cml_surface_kind force)
{
    const struct cml_surface_options options = {.force = force,
                                                .tessellation = {1e-2, CML_NORMALS_ANALYTIC, false}};
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_surfaces_create(bench->list.scenes, &options, &bench->surfaces, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
}

static struct bench set_up(void **state, const char *text, enum cml_surface_kind force)
{
    struct bench bench = {.options = bench_options(5)};
    case_read_ok(state, text, &bench.list);
    represent(&bench, force);
    return bench;
}

static void add_range(const struct bench *bench, const struct cml_engine *engine, uint64_t first,
                      uint64_t count, struct cml_tally *tally)
{
    struct cml_error err = {CML_OK, ""};
    void *self = open_engine(bench, engine);
    assert_int_equal(cml_engine_run_range(engine, self, first, count, tally, &err), CML_OK);
    engine->close(self);
}

static struct cml_tally fly(const struct bench *bench, const struct cml_engine *engine, uint64_t count)
{
    struct cml_tally tally = empty_tally(bench);
    add_range(bench, engine, 0, count, &tally);
    return tally;
}

static const struct {
    const char *const *text;
    enum cml_surface_kind force;
} scenes[] = {{&planes, CML_SURFACE_AUTO},
              {&hills, CML_SURFACE_AUTO},
              {&hills, CML_SURFACE_MESH},
              {&glass, CML_SURFACE_AUTO}};
enum { num_scenes = sizeof scenes / sizeof scenes[0] };

static void threads_and_chunks_do_not_change_a_bit(void **state)
{
    static const int threads[] = {2, 3, 7, 1, 1, 3};
    static const uint64_t chunks[] = {0, 0, 0, 1, 1000000, 1000};
    for (int s = 0; s < num_scenes; s++) {
        struct bench bench = set_up(state, *scenes[s].text, scenes[s].force);
        struct cml_tally one = fly(&bench, cml_engine_cpu(), PACKETS / 8);
        assert_weight_balances(&one, PACKETS / 8);
        for (int i = 0; i < 6; i++) {
            bench.options.threads = threads[i];
            bench.options.chunk = chunks[i];
            struct cml_tally other = fly(&bench, cml_engine_cpu(), PACKETS / 8);
            expect_same(&one, &other, *scenes[s].text);
            cml_tally_free(&other);
        }
        cml_tally_free(&one);
        tear_down(&bench);
    }
}

static void ranges_add_up_to_the_whole(void **state)
{
    const struct cml_engine *const engines[] = {cml_engine_cpu(), &cml_engine_reference};
    static const uint64_t cuts[] = {0, 1, 31, 32, 1000, 2999, 3000};
    for (int s = 0; s < num_scenes; s++)
        for (int e = 0; e < 2; e++) {
            struct bench bench = set_up(state, *scenes[s].text, scenes[s].force);
            struct cml_tally whole = fly(&bench, engines[e], 3000), parts = empty_tally(&bench);
            void *self = open_engine(&bench, engines[e]);
            struct cml_error err;
            for (int i = 0; i + 1 < (int)(sizeof cuts / sizeof *cuts); i++)
                assert_int_equal(
                    cml_engine_run_range(engines[e], self, cuts[i], cuts[i + 1] - cuts[i], &parts, &err),
                    CML_OK);
            engines[e]->close(self);
            expect_same(&whole, &parts, *scenes[s].text);
            assert_weight_balances(&whole, 3000);
            cml_tally_free(&whole);
            cml_tally_free(&parts);
            tear_down(&bench);
        }
}

static void one_packet_and_none_and_a_far_index_work(void **state)
{
    struct bench bench = set_up(state, hills, CML_SURFACE_AUTO);
    struct cml_tally one = fly(&bench, cml_engine_cpu(), 1), none = fly(&bench, cml_engine_cpu(), 0);
    assert_weight_balances(&one, 1);
    assert_int_equal(none.count[CML_COUNT_PHOTONS], 0);
    struct cml_tally far = empty_tally(&bench), near = empty_tally(&bench);
    add_range(&bench, cml_engine_cpu(), ((uint64_t)1 << 48) - 100, 100, &far);
    add_range(&bench, cml_engine_cpu(), ((uint64_t)1 << 32) - 100, 100, &near);
    assert_weight_balances(&far, 100);
    assert_true(memcmp(far.balance, near.balance, sizeof far.balance) != 0);
    cml_tally_free(&one);
    cml_tally_free(&none);
    cml_tally_free(&far);
    cml_tally_free(&near);
    tear_down(&bench);
}

static void seed_and_run_number_change_the_packets(void **state)
{
    struct bench bench = set_up(state, planes, CML_SURFACE_AUTO);
    struct cml_tally tally[4];
    for (int i = 0; i < 4; i++) {
        bench.options.seed = i == 1 ? 6 : (i == 2 ? 5 + ((uint64_t)1 << 32) : 5);
        bench.options.run = i == 3;
        tally[i] = fly(&bench, cml_engine_cpu(), 500);
    }
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < i; k++)
            assert_true(memcmp(tally[i].balance, tally[k].balance, sizeof tally[i].balance) != 0);
    for (int i = 0; i < 4; i++) cml_tally_free(&tally[i]);
    tear_down(&bench);
}

static void on_event(void *context, const struct cml_trace_event *event)
{
    (void)event;
    ++*(long *)context;
}

/* A packet that is traced alone ends as in the run, with and without an observer of its path. */
static void a_trace_is_the_packet_of_the_run(void **state)
{
    const struct cml_engine *const engines[] = {cml_engine_cpu(), &cml_engine_reference};
    static const enum cml_balance_term term_of[CML_NUM_FATES] = {
        [CML_FATE_REFLECTED] = CML_BALANCE_REFLECTED,
        [CML_FATE_TRANSMITTED] = CML_BALANCE_TRANSMITTED,
        [CML_FATE_SPECULAR] = CML_BALANCE_SPECULAR,
    };
    struct bench bench = set_up(state, hills, CML_SURFACE_AUTO);
    for (uint64_t index = 0; index < 200; index++) {
        const struct cml_engine *engine = engines[index & 1];
        struct cml_tally tally = empty_tally(&bench);
        struct cml_error err;
        struct cml_fate_record record, silent;
        long events = 0;
        add_range(&bench, engine, index, 1, &tally);
        void *self = open_engine(&bench, engine);
        assert_int_equal(engine->trace(self, index, on_event, &events, &record, &err), CML_OK);
        assert_int_equal(engine->trace(self, index, NULL, NULL, &silent, &err), CML_OK);
        engine->close(self);
        assert_int_equal(record.interactions, tally.count[CML_COUNT_INTERACTIONS]);
        assert_int_equal(record.boundary_events, tally.count[CML_COUNT_BOUNDARY_EVENTS]);
        assert_true(events >= 2 + (long)record.interactions + (long)record.boundary_events);
        if (term_of[record.fate]) assert_int_equal(tally.balance[term_of[record.fate]], record.weight);
        assert_int_equal(silent.fate, record.fate);
        assert_int_equal(silent.weight, record.weight);
        assert_true(silent.exit[0] == record.exit[0] && silent.direction[2] == record.direction[2]);
        cml_tally_free(&tally);
    }
    tear_down(&bench);
}

/* Multiplies all lengths of a scene (cm) by 2^k. */
static void rescale(struct cml_scene *scene, int k)
{
    scene->dz = ldexp(scene->dz, k);
    scene->dr = ldexp(scene->dr, k);
    for (int m = 0; m <= scene->num_layers + 1; m++) {
        scene->media[m].d = ldexp(scene->media[m].d, k);
        scene->media[m].mua = ldexp(scene->media[m].mua, -k);
        scene->media[m].mus = ldexp(scene->media[m].mus, -k);
    }
    for (int b = 0; b <= scene->num_layers; b++) {
        struct cml_boundary *boundary = &scene->boundaries[b];
        boundary->z = ldexp(boundary->z, k);
        for (int i = 0; i < boundary->radial.n; i++) {
            boundary->radial.r[i] = ldexp(boundary->radial.r[i], k);
            boundary->radial.h[i] = ldexp(boundary->radial.h[i], k);
        }
    }
}

static void the_unit_of_length_does_not_change_a_bit(void **state)
{
    static const int powers[] = {-20, -3, 7, 20};
    for (int s = 0; s < num_scenes; s++) {
        struct bench bench = set_up(state, *scenes[s].text, scenes[s].force);
        struct cml_tally one = fly(&bench, cml_engine_cpu(), 2000);
        for (int i = 0; i < 4; i++) {
            cml_surfaces_free(&bench.surfaces);
            rescale(bench.list.scenes, powers[i]);
            represent(&bench, scenes[s].force);
            struct cml_tally other = fly(&bench, cml_engine_cpu(), 2000);
            expect_same(&one, &other, *scenes[s].text);
            cml_tally_free(&other);
            rescale(bench.list.scenes, -powers[i]);
        }
        cml_tally_free(&one);
        tear_down(&bench);
    }
}

/* Engines in single and double precision draw the same random numbers, so nearly every packet has the same
 * life in both. */
static void the_engines_agree_packet_by_packet(void **state)
{
    for (int s = 0; s < num_scenes; s++) {
        struct bench bench = set_up(state, *scenes[s].text, scenes[s].force);
        void *cpu = open_engine(&bench, cml_engine_cpu()),
             *reference = open_engine(&bench, &cml_engine_reference);
        int differ = 0;
        const int packets = (s < 2 ? PACKETS : PACKETS / 4) / (SANITIZED ? 4 : 1);
        for (int index = 0; index < packets; index++) {
            struct cml_fate_record a, b;
            struct cml_error err;
            assert_int_equal(cml_engine_cpu()->trace(cpu, (uint64_t)index, NULL, NULL, &a, &err), CML_OK);
            assert_int_equal(cml_engine_reference.trace(reference, (uint64_t)index, NULL, NULL, &b, &err),
                             CML_OK);
            differ += a.fate != b.fate || a.interactions != b.interactions ||
                      a.boundary_events != b.boundary_events;
        }
        cml_engine_cpu()->close(cpu);
        cml_engine_reference.close(reference);
        printf("scene %d: %d of %d packets differ\n", s, differ, packets);
        assert_true(differ * 1000 <= packets);
        tear_down(&bench);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(threads_and_chunks_do_not_change_a_bit, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(ranges_add_up_to_the_whole, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(one_packet_and_none_and_a_far_index_work, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(seed_and_run_number_change_the_packets, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(a_trace_is_the_packet_of_the_run, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(the_unit_of_length_does_not_change_a_bit, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(the_engines_agree_packet_by_packet, case_setup, case_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
