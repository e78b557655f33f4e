/* Measures the cost of each vector loop of the CPU engine, in ns per packet and step: the loop alone, and
 * the time that the whole pass saves without the loop.
 * Every lane holds a packet deep in a thick medium. The sum is therefore a lower bound, to which
 * boundaries, launches and ends of packets add. Prints CSV. SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 199309L
#define CML_LEVEL stages
#include "engine/cpu/engine_cpu_level.c"

#include "thread_clock.h"

#include <stdio.h>

enum stage { DRAW, FLY, INTERACT, SCATTER, INTERACT_NONE, REACH, REFLECT, FLY_AGAIN, EXIT, LAUNCH, STAGES };
static const char *const names[STAGES] = {
    [DRAW] = "draw: the block of the next interaction",
    [FLY] = "fly: optical depth, distance, nearness",
    [INTERACT] = "interact: hop, drop, spin",
    [SCATTER] = "scatter: into A_rz",
    [INTERACT_NONE] = "interact without A_rz",
    [REACH] = "reach planes (every lane is at one)",
    [REFLECT] = "reflect: Fresnel, reflection, refraction (every lane)",
    [FLY_AGAIN] = "fly again, after a plane (every lane)",
    [EXIT] = "exit: collect the packet, its bins, balance and squares (every lane)",
    [LAUNCH] = "launch (every lane)",
};
#ifndef CML_TRIES /* of each stage; tests/cli/bench_programs.sh needs one */
#define CML_TRIES 25
#endif

enum { PASS = SCATTER + 1, CELLS = 52 * 202, EXIT_CELLS = 51 * 30 };

static struct cml_bundle bundle;
static struct cml_world world = {
    .setup = {.num_layers = 1, .nr = 50, .nz = 200, .na = 30, .per_dr = 100, .per_dz = 100, .per_da = 19}};
static uint64_t cells[3 + 2 * EXIT_CELLS + CELLS];
static struct cml_tally tally = {.grid.absorption = true,
                                 .A_l = cells,
                                 .Rd_ra = cells + 3,
                                 .Tt_ra = cells + 3 + EXIT_CELLS,
                                 .A_rz = cells + 3 + 2 * EXIT_CELLS};
static struct cml_flight flight = {
    .world = &world, .b = &bundle, .tally = &tally, .pencil = 1, .live = ~(uint64_t)0};
static volatile cml_u32 sink;

/* Fills the bundle with packets in a medium of mua 0.1, mus 90, n 1.4, far from every boundary. */
static void fill_bundle(void)
{
    const struct cml_lane_medium medium = {.mut = 90.1f,
                                           .mfp = 1 / 90.1f,
                                           .g = 0.9f,
                                           .n = 1.4f,
                                           .n_above = 1,
                                           .n_below = 1,
                                           .start_above = -INFINITY,
                                           .start_below = INFINITY,
                                           .stop_above = -1e9f,
                                           .stop_below = 1e9f};
    const real *row = &medium.mut;
    bundle.lanes = CML_LANES;
    flight.start = (struct cml_packet){.u = {0, 0, 1}, .w = CML_WEIGHT_ONE, .medium = 1, .entered = 1};
    for (int i = 0; i < CML_LANES; i++) {
        bundle.uz[i] = 1;
        bundle.z[i] = 0.5f;
        bundle.tau[i] = 1;
        bundle.w[i] = bundle.flushed_w[i] = CML_WEIGHT_ONE;
        bundle.index_low[i] = (cml_u32)i;
        bundle.medium[i] = bundle.entered[i] = 1;
        for (size_t k = 0; k < CML_LANE_MEDIUM_MEMBERS; k++) bundle.of_medium[k][i] = row[k];
    }
}

static void set_task(int task)
{
    for (int i = 0; i < CML_LANES; i++) bundle.task[i] = task;
}

static void interact(const int tally_cells)
{
    sink = (cml_u32)(tally_cells ? cml_bundle_interact(&world.setup, &bundle)
                                 : cml_bundle_scatter(&world.setup, &bundle));
}

static void exit_lanes(void)
{
    for (int first = 0; first < CML_LANES; first += CML_GROUP) cml_exit_group(&flight, first, CML_GROUP_MASK);
}

static void launch_lanes(void)
{
    flight.left = UINT64_MAX;
    flight.ended = ~(uint64_t)0;
    cml_refill(&flight);
}

static void run_stage(int stage)
{
    switch (stage) {
    case DRAW:
        cml_bundle_draw(&world.setup, &bundle);
        break;
    case FLY:
        sink = (cml_u32)cml_bundle_fly(&bundle);
        break;
    case INTERACT:
        interact(1);
        break;
    case INTERACT_NONE:
        interact(0);
        break;
    case SCATTER:
        cml_scatter_deposits(&bundle, &tally, 0);
        break;
    case REACH:
        sink = (cml_u32)cml_bundle_reach_planes(&bundle, 0);
        break;
    case REFLECT:
        cml_bundle_reflect_or_refract(&world.setup, &bundle);
        break;
    case FLY_AGAIN:
        cml_bundle_fly_again(&bundle);
        break;
    case EXIT:
        exit_lanes();
        break;
    default:
        launch_lanes();
    }
}

/* Returns the least time of several tries, ns per lane, of a pass over stages from..to-1 without one of
 * them. */
static double time_stages(int from, int to, int without)
{
    enum { tries = CML_TRIES, repeats = 10000 };
    double best = INFINITY;
    for (int n = 0; n < tries; n++) {
        const double begin = thread_seconds();
        for (int k = 0; k < repeats; k++)
            for (int stage = from; stage < to; stage++)
                if (stage != without) run_stage(stage);
        const double seconds = thread_seconds() - begin;
        if (seconds < best) best = seconds;
    }
    return 1e9 * best / (repeats * CML_LANES);
}

int main(void)
{
    fill_bundle();
    const double pass = time_stages(0, PASS, -1);
    printf("stage,ns_alone,ns_saved_when_left_out\n\"whole pass\",%.2f,\n", pass);
    for (int stage = 0; stage < PASS; stage++)
        printf("\"%s\",%.2f,%.2f\n", names[stage], time_stages(stage, stage + 1, -1),
               pass - time_stages(0, PASS, stage));
    for (int stage = PASS; stage < STAGES; stage++) {
        set_task(stage < REACH ? CML_LANE_INTERACT
                               : (stage == REFLECT ? CML_LANE_AT_PLANE : CML_LANE_MAY_HIT));
        printf("\"%s\",%.2f,\n", names[stage], time_stages(stage, stage + 1, -1));
    }
    return 0;
}
