/* Packets of bench_divergence: flown one at a time by the walk of kernels/walk.h, each step looked at before
 * it is done. SPDX-License-Identifier: MIT */
#ifndef CML_BENCH_DIVERGENCE_H
#define CML_BENCH_DIVERGENCE_H

#include "device_layout.h"
#include "engine/terminated_packets_inl.h"
#include "engine/world.h"
#include "input/mci.h"
#include "walk.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LANES = 32 };

/* What a warp does, in the order of a pass (kernels/transport.cl). FLY_AGAIN: once more, for lanes apart. */
enum stage { FLY, FLY_AGAIN, LATTICE, BOUNDARY, INTERACT, DEPOSIT, ROULETTE, REPLACE, NUM_STAGES };
static const char *const stage_names[NUM_STAGES] = {"fly",      "fly again", "lattice",  "boundary",
                                                    "interact", "deposit",   "roulette", "replace"};

struct bench_scene {
    const char *name;
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct cml_owned_world owned;
    struct cml_tally tally;
    struct cml_deposits to;
    int only_planes;
};

static cml_status bench_scene_open(const char *path, struct bench_scene *scene, struct cml_error *err)
{
    const struct cml_surface_options how = {.force = CML_SURFACE_AUTO, .tessellation = {.tolerance = 1e-3}};
    const struct cml_engine_options options = {
        .seed = 1, .lattice = true, .roulette = {0.003, 0.01}, .reentry = true, .absorption = true};
    const char *slash = strrchr(path, '/');
    *scene = (struct bench_scene){.name = slash ? slash + 1 : path, .only_planes = 1};
    CML_TRY(cml_mci_read(path, NULL, &scene->list, err));
    const struct cml_scene *first = &scene->list.scenes[0];
    CML_TRY(cml_surfaces_create(first, &how, &scene->surfaces, err));
    const struct cml_grid grid = cml_engine_grid(first, &scene->surfaces, &options);
    CML_TRY(cml_tally_create(&grid, &scene->tally, err));
    CML_TRY(cml_owned_world_create(first, &scene->surfaces, &options, &scene->owned, err));
    scene->to = cml_deposits_of(&scene->tally);
    for (int b = 0; b < scene->surfaces.count; b++)
        if (scene->surfaces.item[b].kind != CML_SURFACE_PLANE) scene->only_planes = 0;
    return CML_OK;
}

static void bench_scene_close(struct bench_scene *scene)
{
    cml_owned_world_free(&scene->owned);
    cml_tally_free(&scene->tally);
    cml_surfaces_free(&scene->surfaces);
    cml_scene_list_clear(&scene->list);
}

/* What a step is. */
struct step {
    int even;      /* draws from the lattice */
    int near;      /* boundaries have to be looked for */
    int interacts; /* else a boundary event or an end */
    int low;       /* plays roulette */
    int ends;
    uint32_t cell; /* of A_rz, where it interacts */
    int layer;     /* it ends deposits in a layer: one addition to A_l */
    int sums;      /* additions to the weight balance and the counts at its end, and to Rd_ra or Tt_ra */
};

/* A packet whose next step is known: it has done it. */
struct packet_ahead {
    struct cml_packet packet;
    struct step step;
    uint64_t pending; /* deposits that A_l has not got yet */
};

/* cml_device_is_near with the z of cml_device_load_medium. */
static int packet_is_near(const struct cml_world *world, const struct cml_packet *packet, real s)
{
    const int m = packet->medium, layers = world->setup.num_layers, top = m > 0, bottom = m <= layers;
    const real above = top ? world->surfaces[m - 1].highest : -CML_INFINITY;
    const real below = bottom ? world->media[m].span + world->surfaces[m].lowest : CML_INFINITY;
    const real start_above = top && cml_is_plane(world, m - 1) ? -CML_INFINITY : above;
    const real start_below = bottom && cml_is_plane(world, m) ? CML_INFINITY : below;
    const real z = packet->p.z, step = s * packet->u.z, end = z + step, err = cml_err_depth(z, step);
    return !((end - err > above) & (end + err < below) & (z - err > start_above) & (z + err < start_below));
}

/* Of cml_score (kernels/transport.cl), which leaves out those of 0. */
static int additions_at_end(const struct cml_packet *packet)
{
    const int exits = packet->fate == CML_FATE_REFLECTED || packet->fate == CML_FATE_TRANSMITTED;
    return 1 + exits + (packet->w > 0) + (packet->absorbed > 0) + (packet->gained > 0) +
           (packet->roulette > 0) + (packet->interactions > 0) + (packet->boundary_events > 0) +
           (packet->queries > 0);
}

static void packet_look_ahead(const struct bench_scene *scene, struct packet_ahead *ahead)
{
    const struct cml_world *world = &scene->owned.world;
    const struct cml_setup *setup = &world->setup;
    struct cml_packet *packet = &ahead->packet;
    const struct cml_packet before = *packet;
    struct step *step = &ahead->step;
    step->even = packet->interactions < setup->stream.lattice;
    step->near = packet_is_near(world, packet, cml_free_path(world, packet));
    cml_step(world, &scene->to, packet);
    step->interacts = packet->interactions > before.interactions;
    step->ends = packet->fate != CML_FATE_ALIVE;
    step->low = step->interacts && (step->ends || packet->gained != before.gained);
    ahead->pending += packet->absorbed - before.absorbed;
    step->layer = (!step->interacts || step->low) && ahead->pending > 0;
    if (step->layer) ahead->pending = 0;
    step->sums = step->ends ? additions_at_end(packet) : 0;
    step->cell = (uint32_t)(cml_device_column(cml_radial_bin(setup, packet->p.x, packet->p.y), setup->nr, 1) *
                                (setup->nz + 2) +
                            cml_depth_bin(setup, packet->p.z, world->media[before.medium].bins));
}

static void packet_launch(const struct bench_scene *scene, uint64_t index, struct packet_ahead *ahead)
{
    cml_launch(&scene->owned.world, index, &ahead->packet);
    ahead->pending = 0;
    packet_look_ahead(scene, ahead);
}

/* Deposits of warps in A_rz. */
struct conflicts {
    uint32_t near, cells;  /* cells in local memory; all */
    double *count;         /* [cells] deposits */
    double done, all, far; /* deposits of warps, of lanes, of lanes in global memory */
    double same, busiest;  /* lanes whose bin another one hits as well; the most lanes at one bin */
};

/* As many cells as place_windows of src/engine/opencl/opencl_flight.c keeps in the 16 KiB of a GPU's group.
 */
static uint32_t near_cells(const struct cml_setup *setup)
{
    const uint32_t near = 16384 / 8, sums = CML_CELL_LAYER + (uint32_t)(setup->num_layers + 2),
                   exits = (uint32_t)((setup->nr + 1) * setup->na);
    uint32_t used = sums, room = (near - used) / 8;
    used += exits < room ? exits : room;
    room = (near - used) / 8;
    used += exits < room ? exits : room;
    return near - used;
}

static void conflicts_begin(const struct bench_scene *scene, struct conflicts *c)
{
    const struct cml_setup *setup = &scene->owned.world.setup;
    *c = (struct conflicts){.cells = (uint32_t)((setup->nr + 1) * (setup->nz + 2))};
    c->near = near_cells(setup) < c->cells ? near_cells(setup) : c->cells;
    c->count = calloc(c->cells, sizeof *c->count);
    if (!c->count) exit(2);
}

static void conflicts_end(struct conflicts *c)
{
    free(c->count);
}

static void conflicts_note(struct conflicts *c, const uint32_t *cell, int lanes)
{
    int most = 0;
    for (int i = 0; i < lanes; i++) {
        int equal = 0;
        for (int k = 0; k < lanes; k++) equal += cell[k] == cell[i];
        most = equal > most ? equal : most;
        c->same += equal > 1;
        c->count[cell[i]]++;
        c->far += cell[i] >= c->near;
    }
    c->done += lanes > 0;
    c->all += lanes;
    c->busiest += most;
}

/* Probability that two deposits in global memory are in one bin. */
static double conflicts_collision(const struct conflicts *c)
{
    double squares = 0;
    for (uint32_t i = c->near; i < c->cells; i++) squares += c->count[i] * c->count[i];
    return c->far > 0 ? squares / (c->far * c->far) : 0;
}

#endif
