/* What a step near a curved boundary 0 costs, part by part, in ns: bench_queries SCENE.mci [--mesh|--cone].
 * Packets are placed below the boundary of the scene's first run, within its envelope and one mean free path
 * of it, headed anywhere, each with a step of one mean free path; the parts are timed over the same packets
 * one after the other, so that each stands alone. Prints CSV.
 * SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 199309L
#include "engine/world.h"
#include "input/mci.h"
#include "walk.h"
#include "thread_clock.h"

#include <stdio.h>
#include <string.h>

enum { COUNT = 20000, TRIES = 15 };

struct near_packet {
    struct cml_packet packet;
    struct cml_boundary_intervals intervals;
    struct cml_hit hit;
};

static struct near_packet all[COUNT], asked[COUNT], met[COUNT];
static int num_asked, num_met;
static volatile int sink;

static void place(const struct cml_world *world, int i, struct cml_packet *packet)
{
    const struct cml_block a = cml_draw(world->setup.stream, (cml_u64)i, CML_PURPOSE_LAUNCH, 0),
                           b = cml_draw(world->setup.stream, (cml_u64)i, CML_PURPOSE_LAUNCH, 1);
    const struct cml_surface *surface = &world->surfaces[0];
    const real mfp = world->media[1].mfp, low = surface->lowest, high = surface->highest + mfp;
    const struct cml_vec axis = {0, 0, 1};
    *packet = (struct cml_packet){.index = (cml_u64)i, .medium = 1, .on_boundary = -1, .on_primitive = -1};
    packet->p.x = cml_uniform_symmetric(a.w[0]) / 2;
    packet->p.y = cml_uniform_symmetric(a.w[1]) / 2;
    packet->p.z = low + (high - low) * cml_uniform(a.w[2]);
    packet->u = cml_scatter(axis, 0, a.w[3], b.w[0]);
    packet->tau = 1;
    packet->entered = 1;
}

/* Whether the boundary lies straight above a packet: no packet is beyond the one that it meets from below. */
static int is_below(const struct cml_world *world, struct cml_packet packet)
{
    const struct cml_vec up = {0, 0, -1};
    const real far = 2 * (packet.p.z - world->surfaces[0].lowest) + 1;
    const struct cml_boundary_intervals above = {.above = {1, 0, far}, .below = {0, 0, far}};
    struct cml_hit hit;
    packet.u = up;
    return cml_nearest_hit(world, &packet, above, &hit);
}

static void find_reach(const struct cml_world *world, struct near_packet *near)
{
    const struct cml_packet *p = &near->packet;
    near->intervals = cml_find_intervals(world, p, p->tau * world->media[1].mfp);
}

static void query(const struct cml_world *world, struct near_packet *near)
{
    struct cml_packet packet = near->packet;
    sink = cml_nearest_hit(world, &packet, near->intervals, &near->hit);
}

static void cross(const struct cml_world *world, struct near_packet *near)
{
    struct cml_packet packet = near->packet;
    cml_boundary_event(world, &packet, &near->hit);
    sink = packet.fate;
}

/* Least of several tries, ns per call. */
static double time_part(const struct cml_world *world, struct near_packet *packets, int count,
                        void (*part)(const struct cml_world *, struct near_packet *))
{
    double best = INFINITY;
    for (int n = 0; n < TRIES; n++) {
        const double begin = thread_seconds();
        for (int i = 0; i < count; i++) part(world, &packets[i]);
        const double seconds = thread_seconds() - begin;
        if (seconds < best) best = seconds;
    }
    return count > 0 ? 1e9 * best / count : 0;
}

static void report(const struct cml_world *world)
{
    for (int i = 0, placed = 0; i < COUNT; i++) {
        do place(world, placed++, &all[i].packet);
        while (!is_below(world, all[i].packet));
        find_reach(world, &all[i]);
        if (!all[i].intervals.above.meets) continue;
        asked[num_asked++] = all[i];
        query(world, &all[i]);
        if (sink) met[num_met++] = all[i];
    }
    printf("part,share,ns\n\"can it meet the boundary at all\",1,%.1f\n",
           time_part(world, all, COUNT, find_reach));
    printf("\"query\",%.3f,%.1f\n", (double)num_asked / COUNT, time_part(world, asked, num_asked, query));
    printf("\"query that meets it\",%.3f,%.1f\n", (double)num_met / COUNT,
           time_part(world, met, num_met, query));
    printf("\"reflection or refraction there\",%.3f,%.1f\n", (double)num_met / COUNT,
           time_part(world, met, num_met, cross));
}

int main(int argc, char **argv)
{
    struct cml_error err;
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct cml_owned_world owned;
    const struct cml_engine_options options = {.seed = 1, .reentry = true};
    struct cml_surface_options how = {.force = CML_SURFACE_AUTO, .tessellation = {.tolerance = 1e-3}};
    if (argc > 2) how.force = strcmp(argv[2], "--mesh") == 0 ? CML_SURFACE_MESH : CML_SURFACE_CONE;
    const char *path = argc > 1 ? argv[1] : "samples/shapes/hinoise.mci";
    cml_status status = cml_mci_read(path, NULL, &list, &err);
    if (status == CML_OK) status = cml_surfaces_create(&list.scenes[0], &how, &surfaces, &err);
    if (status == CML_OK) status = cml_owned_world_create(&list.scenes[0], &surfaces, &options, &owned, &err);
    if (status != CML_OK) {
        fprintf(stderr, "bench_queries: %s\n", err.text);
        return 2;
    }
    report(&owned.world);
    return 0;
}
