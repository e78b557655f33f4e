/* What the engines that walk one packet at a time share: the scene in `real`, and a packet's entry into a
 * tally. Included by one .c file per precision (CML_DOUBLE or not), like the kernel headers it stands on.
 * SPDX-License-Identifier: MIT */
#ifndef CML_SCALAR_WALK_H
#define CML_SCALAR_WALK_H

#include "engine/engine.h"
#include "surface/ring_horizon.h"
#include "engine/terminated_packets.h"
#include "surface/surface_facets.h"
#include "walk.h"

#include <math.h>
#include <stdlib.h>

/* A world and the arrays it points into. */
struct scalar_world {
    struct cml_world world;
    struct cml_medium *media;
    struct cml_surface *surfaces;
    real *rings; /* [CML_RING_ROWS][rings of all boundaries] */
    int *ring_starts;
    real *clearance; /* deepest, highest one behind the other */
    const struct cml_mesh_surface **meshes;
};

static void scalar_world_free(struct scalar_world *to)
{
    free(to->media);
    free(to->surfaces);
    free(to->rings);
    free(to->ring_starts);
    free(to->clearance);
    free(to->meshes);
}

static size_t count_rings(const struct cml_surface_set *surfaces)
{
    size_t rings = 0;
    for (int b = 0; b < surfaces->count; b++) rings += (size_t)surfaces->item[b].num_rings;
    return rings;
}

static size_t count_clearance_cells(const struct cml_surface_set *surfaces)
{
    size_t cells = 0;
    for (int b = 0; b < surfaces->count; b++) cells += surfaces->item[b].clearance.cells;
    return cells;
}

static cml_status scalar_world_allocate(const struct cml_surface_set *surfaces, struct scalar_world *to,
                                        struct cml_error *err)
{
    const size_t boundaries = (size_t)surfaces->count, rings = count_rings(surfaces);
    const size_t cells = count_clearance_cells(surfaces);
    to->media = calloc(boundaries + 1, sizeof *to->media);
    to->surfaces = calloc(boundaries, sizeof *to->surfaces);
    to->rings = calloc(CML_RING_ROWS * rings + 1, sizeof *to->rings);
    to->ring_starts = calloc(rings + 1, sizeof *to->ring_starts);
    to->meshes = calloc(boundaries, sizeof *to->meshes);
    to->clearance = calloc(2 * cells + 1, sizeof *to->clearance);
    if (to->media && to->surfaces && to->rings && to->ring_starts && to->meshes && to->clearance)
        return CML_OK;
    return cml_fail_memory(
        err, (double)((CML_RING_ROWS * rings + 2 * cells) * sizeof(real) + rings * sizeof(int)), "the scene");
}

static void copy_media(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                       struct cml_medium *media)
{
    for (int m = 0; m <= scene->num_layers + 1; m++) {
        const struct cml_medium_def *from = &scene->media[m];
        const double mut = from->mua + from->mus;
        const bool inside = m > 0 && m <= scene->num_layers;
        const double depth = surfaces->item[m > 0 ? m - 1 : 0].depth;
        media[m].n = (real)from->n;
        media[m].mut = (real)mut;
        media[m].mfp = mut > 0 ? (real)(1 / mut) : CML_INFINITY;
        media[m].absorb = from->mus > 0 ? (real)(from->mua / mut) : (mut > 0 ? 1 + 4 * CML_EPSILON : (real)0);
        media[m].g = (real)from->g;
        media[m].span = (real)(inside ? surfaces->item[m].depth - depth : 0);
        media[m].depth = (real)depth;
        media[m].bins = (real)(depth / scene->dz);
    }
}

/* Rings of one surface, the first of them at `first`. Returns ring_start's parts per cm. */
static real copy_rings(const struct cml_surface_def *from, size_t first, size_t total,
                       struct scalar_world *to)
{
    const int n = from->num_rings;
    int *start = to->ring_starts + first; /* scratch, before it is filled */
    real *r = to->rings + first, *z = r + total, *slope = z + total, *above = slope + total,
         *below = above + total;
    for (int i = 0; i < n; i++) {
        r[i] = (real)from->r[i];
        z[i] = (real)from->z[i];
        slope[i] = (real)from->slope[i];
    }
    cml_ring_horizons(r, z, n, -1, start, above);
    cml_ring_horizons(r, z, n, 1, start, below);
    return cml_ring_starts(r, n, start);
}

static void copy_surfaces(const struct cml_surface_set *from, struct scalar_world *to)
{
    const size_t total = count_rings(from);
    size_t ring = 0;
    for (int b = 0; b < from->count; b++) {
        const struct cml_surface_def *def = &from->item[b];
        to->surfaces[b].kind = (int)def->kind;
        to->surfaces[b].first_ring = (int)ring;
        to->surfaces[b].num_rings = def->num_rings;
        to->surfaces[b].lowest = (real)def->lowest;
        to->surfaces[b].highest = (real)def->highest;
        to->surfaces[b].steepest = (real)(1.00001 * def->steepest + 1e-6); /* more than rounding can turn */
        to->meshes[b] = def->mesh;
        if (def->num_rings) to->surfaces[b].parts_per_cm = copy_rings(def, ring, total, to);
        ring += (size_t)def->num_rings;
    }
    to->world.ring_r = to->rings;
    to->world.ring_z = to->rings + total;
    to->world.ring_slope = to->rings + 2 * total;
    to->world.ring_horizon_above = to->rings + 3 * total;
    to->world.ring_horizon_below = to->rings + 4 * total;
    to->world.ring_start = to->ring_starts;
}

/* What escapes from a plane is in the map already. */
static void set_facets(const struct cml_surface_set *from, const struct cml_map_def *map,
                       struct scalar_world *to)
{
    const int last = from->count - 1;
    int first = 0;
    for (int b = 0; b < from->count; b++) {
        struct cml_facet_range *range = &to->surfaces[b].facets;
        range->first = first;
        range->count = (int)cml_surface_facets(&from->item[b], map);
        first += range->count;
    }
    if (from->item[0].kind != CML_SURFACE_PLANE) to->world.setup.outer_facets[0] = to->surfaces[0].facets;
    if (from->item[last].kind != CML_SURFACE_PLANE)
        to->world.setup.outer_facets[1] = to->surfaces[last].facets;
}

static void copy_clearance(const struct cml_surface_set *from, struct scalar_world *to)
{
    const size_t total = count_clearance_cells(from);
    size_t first = 0;
    for (int b = 0; b < from->count; b++) {
        const struct cml_clearance_map *map = &from->item[b].clearance;
        struct cml_clearance *grid = &to->surfaces[b].clearance;
        int offset = 0;
        grid->size = map->size;
        grid->first = (int)first;
        grid->corner_x = (real)map->corner[0];
        grid->corner_y = (real)map->corner[1];
        grid->per_cell = (real)(map->cell > 0 ? 1 / map->cell : 0);
        for (int l = 0; l < map->levels; l++) {
            grid->level_offset[l] = offset;
            offset += (int)cml_clearance_level_cells(map, l);
        }
        for (size_t i = 0; i < map->cells; i++) {
            to->clearance[first + i] = map->deepest[i];
            to->clearance[total + first + i] = map->highest[i];
        }
        first += map->cells;
    }
    to->world.deepest = to->clearance;
    to->world.highest = to->clearance + total;
}

/* MCML's deterministic specular reflection [manual eqs 3.6, 3.7]: of the first interface, or of both faces of
 * a clear first layer between planes. Sets where the packet then starts. */
static double deterministic_specular(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                     int *medium)
{
    const struct cml_medium_def *m = scene->media;
    const double r1 = pow((m[0].n - m[1].n) / (m[0].n + m[1].n), 2);
    const bool glass = m[1].mua == 0 && m[1].mus == 0 && scene->num_layers > 1 &&
                       surfaces->item[1].kind == CML_SURFACE_PLANE;
    *medium = glass ? 2 : 1;
    if (!glass) return r1;
    const double r2 = pow((m[1].n - m[2].n) / (m[1].n + m[2].n), 2);
    return r1 + (1 - r1) * (1 - r1) * r2 / (1 - r1 * r2);
}

static struct cml_vec to_vec(double x, double y, double z)
{
    const struct cml_vec v = {(real)x, (real)y, (real)z};
    return v;
}

/* P1. A packet that is traced to boundary 0 starts above all of it, by as much as the boundary is high. */
static void set_launch(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                       struct cml_setup *setup)
{
    const struct cml_beam *beam = &scene->beam;
    const struct cml_surface_def *top = &surfaces->item[0];
    const double st = sin(beam->angle), ct = cos(beam->angle), sp = sin(beam->azimuth),
                 cp = cos(beam->azimuth);
    setup->axis = to_vec(st * cp, st * sp, ct);
    setup->e1 = to_vec(ct * cp, ct * sp, -st);
    setup->e2 = to_vec(-sp, cp, 0);
    setup->x0 = (real)beam->x;
    setup->y0 = (real)beam->y;
    setup->disk = (real)(beam->kind == CML_BEAM_DISK ? beam->radius : 0);
    setup->gauss = (real)(beam->kind == CML_BEAM_GAUSSIAN ? beam->radius : 0);
    setup->launch_z = (real)(2 * top->lowest - top->highest);
    if (top->kind == CML_SURFACE_PLANE && beam->angle == 0)
        setup->specular =
            (cml_u32)lrint(deterministic_specular(scene, surfaces, &setup->launch_medium) * CML_WEIGHT_ONE);
}

static void set_map(const struct cml_scene *scene, struct cml_map *map)
{
    const struct cml_map_def *def = &scene->map;
    if (def->nx == 0) return;
    map->nx = def->nx;
    map->ny = def->ny;
    map->na = def->angles ? scene->na : 1;
    map->per_dx = (real)(1 / def->dx);
    map->per_dy = (real)(1 / def->dy);
    map->half_x = (real)(0.5 * def->nx);
    map->half_y = (real)(0.5 * def->ny);
    map->top_bins = (real)(def->top / scene->dz);
}

static void set_up(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                   const struct cml_engine_options *options, struct cml_setup *setup)
{
    *setup = (struct cml_setup){0};
    setup->stream.key[0] = (cml_u32)options->seed;
    setup->stream.key[1] = (cml_u32)(options->seed >> 32);
    setup->stream.key[2] = options->run;
    setup->num_layers = scene->num_layers;
    setup->reentry = options->reentry;
    setup->tally_absorption = options->absorption;
    setup->nr = scene->nr;
    setup->nz = scene->nz;
    setup->na = scene->na;
    setup->per_dr = (real)(1 / scene->dr);
    setup->per_dz = (real)(1 / scene->dz);
    setup->per_da = (real)(scene->na / 1.5707963267948966);
    set_map(scene, &setup->map);
    set_launch(scene, surfaces, setup);
}

static cml_status scalar_world_create(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                      const struct cml_engine_options *options, struct scalar_world *to,
                                      struct cml_error *err)
{
    *to = (struct scalar_world){0};
    const cml_status status = scalar_world_allocate(surfaces, to, err);
    if (status != CML_OK) {
        scalar_world_free(to);
        return status;
    }
    copy_media(scene, surfaces, to->media);
    copy_surfaces(surfaces, to);
    copy_clearance(surfaces, to);
    to->world.media = to->media;
    to->world.surfaces = to->surfaces;
    to->world.meshes = to->meshes;
    to->world.intersect_mesh = cml_mesh_surface_hit;
    set_up(scene, surfaces, options, &to->world.setup);
    if (scene->facets) set_facets(surfaces, &scene->map, to);
    return CML_OK;
}

static inline void run_packets(const struct cml_world *world, uint64_t first, uint64_t count,
                               struct cml_tally *tally)
{
    const struct cml_deposits to = cml_deposits_of(tally);
    struct cml_terminated terminated = {0};
    for (uint64_t i = 0; i < count; i++) {
        struct cml_packet packet;
        cml_walk(world, &to, first + i, &packet);
        cml_tally_events(&packet, tally);
        const struct cml_termination end = cml_termination_of(&packet);
        cml_terminated_push(&world->setup, &terminated, &end, tally);
    }
    cml_terminated_flush(&world->setup, &terminated, tally);
}

struct tracing {
    const struct cml_world *world;
    cml_trace_function *on_event;
    void *context;
};

static void forward_event(void *context, const char *what, const struct cml_packet *packet)
{
    const struct tracing *tracing = context;
    const struct cml_setup *setup = &tracing->world->setup;
    const struct cml_trace_event event = {
        .what = what,
        .medium = packet->medium,
        .position = {packet->p.x + setup->x0, packet->p.y + setup->y0,
                     packet->p.z + tracing->world->media[packet->medium].depth},
        .direction = {packet->u.x, packet->u.y, packet->u.z},
        .weight = packet->w * CML_WEIGHT_UNIT,
    };
    tracing->on_event(tracing->context, &event);
}

static inline struct cml_fate_record record_of(const struct cml_world *world, const struct cml_packet *packet)
{
    const struct cml_fate_record record = {
        .fate = packet->fate,
        .cause = packet->cause,
        .weight = packet->w,
        .interactions = packet->interactions,
        .boundary_events = packet->boundary_events,
        .specular = world->setup.specular * CML_WEIGHT_UNIT,
        .absorbed = (double)packet->absorbed * CML_WEIGHT_UNIT,
        .exit = {packet->exit_x + world->setup.x0, packet->exit_y + world->setup.y0},
        .direction = {packet->u.x, packet->u.y, packet->u.z},
    };
    return record;
}

/* Packets whose deposits go into a tally that is thrown away. on_event may be NULL. */
static inline cml_status trace_packets(const struct cml_world *world, uint64_t first, uint64_t count,
                                       cml_trace_function *on_event, void *context,
                                       struct cml_fate_record *records, struct cml_error *err)
{
    const struct cml_grid grid = {.nr = 1, .nz = 1, .na = 1, .num_layers = world->setup.num_layers};
    struct cml_tally tally;
    CML_TRY(cml_tally_create(&grid, &tally, err));
    struct tracing tracing = {world, on_event, context};
    struct cml_world traced = *world;
    traced.setup.tally_absorption = 0;
    traced.on_event = on_event ? forward_event : NULL;
    traced.on_event_context = &tracing;
    const struct cml_deposits to = cml_deposits_of(&tally);
    for (uint64_t i = 0; i < count; i++) {
        struct cml_packet packet;
        cml_walk(&traced, &to, first + i, &packet);
        records[i] = record_of(world, &packet);
    }
    cml_tally_free(&tally);
    return CML_OK;
}

#endif
