/* Code, included by bundle_curved_search_inl.h only and so compiled once for each level of the processor
 * (engine_cpu_level.c says why). Lanes near curved boundaries, step 1: the part of its path on which each can
 * meet one before it interacts, if any. Asked for many lanes in vector loops, a medium at a time.
 * SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_CURVED_REACH_INL_H
#define CML_BUNDLE_CURVED_REACH_INL_H

#include "engine/cpu/bundle_lanes_inl.h"
#include "engine/cpu/bundle_curved_hits_inl.h"
#include "surface/mesh/grid_lanes_inl.h"

/* Where gathered lanes can meet one boundary: on the part [from, to] of their paths, cm from where they are,
 * if meets is 1. */
struct cml_intervals {
    _Alignas(64) int meets[CML_LANES];
    real from[CML_LANES], to[CML_LANES];
};

#define CML_GATHERED (CML_LANES + CML_GROUP) /* packing writes whole groups */

/* Lanes of one medium, gathered side by side, so that all of them look at the same two boundaries and vectors
 * are full. size: their number, count, rounded up to whole vectors; what lies behind the lanes there may be
 * anything. Positions in the frame of the medium, lengths in cm. */
struct cml_gathered {
    int count, size;
    int lane[CML_LANES];
    _Alignas(64) real x[CML_GATHERED], y[CML_GATHERED], z[CML_GATHERED], ux[CML_GATHERED], uy[CML_GATHERED],
        uz[CML_GATHERED];
    real s[CML_GATHERED];
    struct cml_intervals above, below;
    struct cml_hits hits_above, hits_below;
    struct cml_grid_lanes rays; /* of those lanes that vector loops can answer */
};

/* Gathers lanes, in the order of their numbers: each column is packed group by group. */
static void cml_gather_lanes(const struct cml_bundle *b, uint64_t lanes, struct cml_gathered *gathered)
{
    int at = 0;
    for (int first = 0; first < CML_LANES; first += CML_GROUP) {
        const cml_u32 mask = (cml_u32)(lanes >> first) & CML_GROUP_MASK;
        if (!mask) continue;
        cml_group_pack(b->x + first, mask, gathered->x + at);
        cml_group_pack(b->y + first, mask, gathered->y + at);
        cml_group_pack(b->z + first, mask, gathered->z + at);
        cml_group_pack(b->ux + first, mask, gathered->ux + at);
        cml_group_pack(b->uy + first, mask, gathered->uy + at);
        cml_group_pack(b->uz + first, mask, gathered->uz + at);
        cml_group_pack(b->s + first, mask, gathered->s + at);
        at += __builtin_popcount(mask);
    }
    gathered->count = at;
    gathered->size = cml_whole_vectors(at);
}

/* cml_surface_interval of a plane, for gathered lanes. depth: of the plane in the frame of the medium; side:
 * +1 the lanes are below it, -1 above. */
CML_LOOP void cml_gathered_plane(const struct cml_gathered *c, real depth, real side,
                                 struct cml_intervals *ahead)
{
    const int size = c->size;
#pragma omp simd
    for (int k = 0; k < size; k++) {
        const real z = c->z[k] - depth, uz = c->uz[k], s = c->s[k];
        ahead->meets[k] = (side * uz < 0) & (-z / uz < s);
        ahead->from[k] = 0;
        ahead->to[k] = s;
    }
}

/* cml_curved_interval for gathered lanes, without its branches: both ways of every branch are computed and
 * selected, with the same results. depth, side as above. form is constant, so that each caller has a loop
 * for its kind of pyramid. */
__attribute__((always_inline)) static inline void
cml_gathered_curved(const struct cml_world *world, const struct cml_surface *shared,
                    const struct cml_gathered *c, real depth, real side, struct cml_intervals *ahead,
                    const int form)
{
    const struct cml_surface surface = *shared;
    const struct cml_clearance *grid = &surface.clearance;
    const real *restrict const bounds = side > 0 ? world->deepest : world->highest;
    const real *restrict const horizons = side > 0 ? world->horizon_below : world->horizon_above;
    const real nearest = side > 0 ? surface.highest : surface.lowest;
    const int size = c->size;
#pragma omp simd
    for (int k = 0; k < size; k++) {
        const struct cml_vec p = {c->x[k], c->y[k], c->z[k] - depth}, u = {c->ux[k], c->uy[k], c->uz[k]};
        const real s = c->s[k], inside = side * (nearest - p.z), away = side * u.z, there = inside / away;
        const real horizon = form == CML_CLEARANCE_RADII
                                 ? surface.steepest
                                 : cml_cell_horizon(grid, horizons, cml_from_scene_axis(world, p), form);
        const int passes = inside < away * s, leads_away = cml_heads_away(horizon, u, side);
        const int misses = ((away < 0) & passes) | ((away >= 0) & ((inside < 0) | leads_away));
        const struct cml_interval within = {!misses, inside < 0 ? there : (real)0,
                                            (away >= 0) & passes ? there : s};
        const struct cml_vec start = cml_from_scene_axis(world, cml_along(p, within.from, u));
        const struct cml_interval left = cml_clip_interval(grid, bounds, start, u, side, within, form);
        ahead->meets[k] = left.meets;
        ahead->from[k] = left.from;
        ahead->to[k] = left.to;
    }
}

/* Below cones: clearance by radius. */
CML_LOOP void cml_gathered_rings(const struct cml_world *world, const struct cml_surface *surface,
                                 const struct cml_gathered *c, real depth, real side,
                                 struct cml_intervals *ahead)
{
    cml_gathered_curved(world, surface, c, depth, side, ahead, CML_CLEARANCE_RADII);
}

/* Below a mesh: clearance by cells of the x-y plane. */
CML_LOOP void cml_gathered_mesh(const struct cml_world *world, const struct cml_surface *surface,
                                const struct cml_gathered *c, real depth, real side,
                                struct cml_intervals *ahead)
{
    cml_gathered_curved(world, surface, c, depth, side, ahead, CML_CLEARANCE_SQUARE);
}

/* Below a mesh that is repeated: by cells of its period. */
CML_LOOP void cml_gathered_tile(const struct cml_world *world, const struct cml_surface *surface,
                                const struct cml_gathered *c, real depth, real side,
                                struct cml_intervals *ahead)
{
    cml_gathered_curved(world, surface, c, depth, side, ahead, CML_CLEARANCE_PERIOD);
}

/* Intervals of gathered lanes with one boundary of their medium, seen from `side`. The outer media have only
 * one; on the other side nothing is met. depth: of the boundary in the frame of the medium, cm. */
static void cml_gathered_boundary(const struct cml_flight *f, int boundary, real depth, real side,
                                  struct cml_intervals *ahead)
{
    const struct cml_world *world = f->world;
    if (boundary < 0 || boundary > world->setup.num_layers) {
        memset(ahead->meets, 0, sizeof ahead->meets);
        return;
    }
    const struct cml_surface *surface = &world->surfaces[boundary];
    if (surface->kind == CML_SURFACE_PLANE)
        cml_gathered_plane(f->gathered, depth, side, ahead);
    else if (surface->kind == CML_SURFACE_CONE)
        cml_gathered_rings(world, surface, f->gathered, depth, side, ahead);
    else if (surface->clearance.form == CML_CLEARANCE_PERIOD)
        cml_gathered_tile(world, surface, f->gathered, depth, side, ahead);
    else
        cml_gathered_mesh(world, surface, f->gathered, depth, side, ahead);
}

/* cml_find_intervals for lanes of one medium: with its boundary above, then with the one below. */
static void cml_gather_intervals(const struct cml_flight *f, int medium, uint64_t lanes)
{
    struct cml_gathered *gathered = f->gathered;
    cml_gather_lanes(f->b, lanes, gathered);
    cml_gathered_boundary(f, medium - 1, 0, 1, &gathered->above);
    cml_gathered_boundary(f, medium, f->world->media[medium].span, -1, &gathered->below);
}

/* That of the k-th gathered lane. */
static struct cml_interval cml_interval_of(const struct cml_intervals *of, int k)
{
    const struct cml_interval s = {of->meets[k], of->from[k], of->to[k]};
    return s;
}

/* Those of the lanes that are in a medium. */
static uint64_t cml_lanes_in_medium(const struct cml_bundle *b, uint64_t lanes, int medium)
{
    uint64_t mask = 0;
    for (int first = 0; first < CML_LANES; first += CML_GROUP)
        mask |= (uint64_t)cml_group_equal(b->medium + first, medium) << first;
    return lanes & mask;
}

#endif
