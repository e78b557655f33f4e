/* Code, included by bundle_curved_search_inl.h only: lanes near curved boundaries, step 1. Vector loops find
 * the part of its path on which a lane can meet a boundary before it interacts, if any, for many lanes, a
 * medium at a time.
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_lanes_inl.h"
#include "engine/cpu/bundle_curved_hits_inl.h"
#include "surface/mesh/grid_lanes_inl.h"

/* Sets `bit` in `safe` of the lanes that are in a medium and have a path that is safe for one of its
 * boundaries. depth: of the boundary in the frame of the medium, cm. */
CML_LOOP void cml_bundle_find_safe(struct cml_bundle *b, const struct cml_safe_cells *shared, int medium,
                                   real depth, int bit)
{
    const struct cml_safe_cells cells = *shared;
    const int lanes = b->lanes;
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const struct cml_vec p = {b->x[i], b->y[i], b->z[i] - depth}, u = {b->ux[i], b->uy[i], b->uz[i]};
        const int is_safe = cml_path_is_safe(&cells, p, u, b->s[i]);
        b->safe[i] |= (b->medium[i] == medium) & is_safe ? bit : 0;
    }
}

/* Sorts the lanes with MAY_HIT. They get MAY_HIT_CURVED if they can meet a curved boundary, MAY_RETURN if
 * they head away from this boundary, INTERACT if they can meet no boundary before the interaction, and keep
 * MAY_HIT for a plane. steepest: the greatest slope of any curved boundary; a direction that leaves such a
 * boundary more steeply cannot meet it, however close it begins. safe: 1 if `safe` of the bundle holds safe
 * paths; constant, so that each caller below has a loop of its own. Returns 1 if any lane has MAY_HIT_CURVED
 * or MAY_RETURN. */
__attribute__((always_inline)) static inline int cml_bundle_classify(struct cml_bundle *b, real steepest,
                                                                     const int safe)
{
    const int lanes = b->lanes;
    int any = 0;
#pragma omp simd reduction(| : any)
    for (int i = 0; i < lanes; i++) {
        const real ux = b->ux[i], uy = b->uy[i], uz = b->uz[i], s = b->s[i];
        const int task = b->task[i];
        const int steep = uz * uz >= steepest * steepest * (ux * ux + uy * uy);
        const int plane_above = !(CML_OF_MEDIUM(b, start_above)[i] > -CML_INFINITY),
                  plane_below = !(CML_OF_MEDIUM(b, start_below)[i] < CML_INFINITY);
        const struct cml_lane_candidates ahead = cml_find_lane_candidates(b, i, s);
        const int known = safe ? b->safe[i] : 0;
        const int above = (ahead.starts_above | ahead.ends_above) & !plane_above & !(known & CML_SAFE_BELOW),
                  below = (ahead.starts_below | ahead.ends_below) & !plane_below & !(known & CML_SAFE_ABOVE);
        const int plane = (ahead.ends_above & plane_above) | (ahead.ends_below & plane_below);
        const int away = (above & (uz > 0)) | (below & (uz < 0)),
                  ahead_of = (above & !(uz > 0)) | (below & !(uz < 0));
        const int finite = s < CML_INFINITY;
        const int curved = ahead_of | (away & !steep & (plane | !finite)),
                  may_return = away & !steep & !curved;
        const int free = (!plane) & finite ? CML_LANE_INTERACT : CML_LANE_MAY_HIT;
        const int next = curved ? CML_LANE_MAY_HIT_CURVED : (may_return ? CML_LANE_MAY_RETURN : free);
        b->task[i] = task == CML_LANE_MAY_HIT ? next : task;
        any |= (task == CML_LANE_MAY_HIT) & (curved | may_return);
    }
    return any;
}

/* Runs cml_bundle_classify. safe: true if a boundary has safe distances, so that `safe` of the bundle is
 * filled for each lane's path. */
CML_LOOP int cml_bundle_classify_lanes(struct cml_bundle *b, real steepest, bool safe)
{
    return safe ? cml_bundle_classify(b, steepest, 1) : cml_bundle_classify(b, steepest, 0);
}

/* The intervals of gathered lanes for one boundary: if meets is 1, a lane can meet the boundary on the part
 * [from, to] of its path, cm from its place. */
struct cml_intervals {
    _Alignas(64) int meets[CML_LANES];
    real from[CML_LANES], to[CML_LANES];
};

#define CML_GATHERED (CML_LANES + CML_GROUP) /* room for lanes; packing writes whole groups */

/* Lanes of one medium, gathered side by side, so that all examine the same two boundaries and vectors are
 * full. count: number of lanes; size: count rounded up to whole vectors; entries behind the lanes may hold
 * anything. Positions are in the frame of the medium, lengths in cm. */
struct cml_gathered {
    int count, size;
    int lane[CML_LANES];
    _Alignas(64) real x[CML_GATHERED], y[CML_GATHERED], z[CML_GATHERED], ux[CML_GATHERED], uy[CML_GATHERED],
        uz[CML_GATHERED];
    real s[CML_GATHERED];
    struct cml_intervals above, below;
    struct cml_hits hits_above, hits_below;
    struct cml_grid_lanes rays; /* rays of the lanes that vector loops can answer */
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

/* Finds on which part of their paths gathered lanes can meet a plane, as cml_surface_interval does. depth:
 * of the plane in the frame of the medium; side: +1 the lanes are below it, -1 above. */
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

/* Finds on which part of their paths gathered lanes can meet a curved boundary, as cml_curved_interval does,
 * but without branches: both ways of every branch are computed, and one is selected. depth: of the
 * boundary's frame in that of the medium; side: +1 the lanes are below, -1 above. form: constant, so that
 * each kind of pyramid has its own loop. */
__attribute__((always_inline)) static inline void
cml_gathered_curved(const struct cml_world *world, const struct cml_surface *shared,
                    const struct cml_gathered *c, real depth, real side, struct cml_intervals *ahead,
                    const int form)
{
    const struct cml_surface surface = *shared;
    const struct cml_depth_bounds *map = &surface.depths;
    const real *restrict const bounds = side > 0 ? world->deepest : world->highest;
    const real *restrict const horizons = side > 0 ? world->horizon_below : world->horizon_above;
    const real nearest = side > 0 ? surface.highest : surface.lowest;
    const int size = c->size;
#pragma omp simd
    for (int k = 0; k < size; k++) {
        const struct cml_vec p = {c->x[k], c->y[k], c->z[k] - depth}, u = {c->ux[k], c->uy[k], c->uz[k]};
        const real s = c->s[k], inside = side * (nearest - p.z), away = side * u.z, there = inside / away;
        const real horizon = form == CML_BOUNDS_RADII
                                 ? surface.steepest
                                 : cml_cell_horizon(map, horizons, cml_from_scene_axis(world, p), form);
        const int passes = inside < away * s, leads_away = cml_heads_away(horizon, u, side);
        const int misses = ((away < 0) & passes) | ((away >= 0) & ((inside < 0) | leads_away));
        const struct cml_interval within = {!misses, inside < 0 ? there : (real)0,
                                            (away >= 0) & passes ? there : s};
        const struct cml_vec start = cml_from_scene_axis(world, cml_along(p, within.from, u));
        const struct cml_interval left = cml_clip_interval(map, bounds, start, u, side, within, form);
        ahead->meets[k] = left.meets;
        ahead->from[k] = left.from;
        ahead->to[k] = left.to;
    }
}

/* Finds intervals by the form of the boundary's pyramid: radius for cones, cells of the x-y plane for a mesh,
 * cells of the period for a repeated mesh. */
CML_LOOP void cml_gathered_by_form(const struct cml_world *world, const struct cml_surface *surface,
                                   const struct cml_gathered *c, real depth, real side,
                                   struct cml_intervals *ahead)
{
    if (surface->kind == CML_SURFACE_CONE)
        cml_gathered_curved(world, surface, c, depth, side, ahead, CML_BOUNDS_RADII);
    else if (surface->depths.form == CML_BOUNDS_PERIOD)
        cml_gathered_curved(world, surface, c, depth, side, ahead, CML_BOUNDS_PERIOD);
    else
        cml_gathered_curved(world, surface, c, depth, side, ahead, CML_BOUNDS_SQUARE);
}

/* Finds the intervals of gathered lanes for one boundary of their medium, seen from `side`. An outer medium
 * has only one boundary, so on its other side nothing is met. depth: of the boundary in the frame of the
 * medium, cm. */
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
    else
        cml_gathered_by_form(world, surface, f->gathered, depth, side, ahead);
}

/* Finds for lanes of one medium on which parts of their paths they can meet the boundary above, and the one
 * below. */
static void cml_gather_intervals(const struct cml_flight *f, int medium, uint64_t lanes)
{
    struct cml_gathered *gathered = f->gathered;
    cml_gather_lanes(f->b, lanes, gathered);
    cml_gathered_boundary(f, medium - 1, 0, 1, &gathered->above);
    cml_gathered_boundary(f, medium, f->world->media[medium].span, -1, &gathered->below);
}

/* Returns the interval of the k-th gathered lane. */
static struct cml_interval cml_interval_of(const struct cml_intervals *of, int k)
{
    const struct cml_interval s = {of->meets[k], of->from[k], of->to[k]};
    return s;
}

/* Finds the boundaries for which the paths of lanes are safe. It looks at the layers on either side of every
 * boundary that has safe distances, if lanes there may hit one. */
static void cml_find_safe_lanes(const struct cml_flight *f)
{
    const struct cml_world *world = f->world;
    const int layers = world->setup.num_layers;
    const uint64_t lanes = cml_lanes_equal(f->b->task, CML_LANE_MAY_HIT);
    memset(f->b->safe, 0, sizeof f->b->safe);
    for (int b = 0; b <= layers; b++) {
        const struct cml_safe_cells *cells = &world->safe_cells[b];
        if (cells->nx == 0) continue;
        if (b < layers && (lanes & cml_lanes_equal(f->b->medium, b + 1)))
            cml_bundle_find_safe(f->b, cells, b + 1, 0, CML_SAFE_BELOW);
        if (b > 0 && (lanes & cml_lanes_equal(f->b->medium, b)))
            cml_bundle_find_safe(f->b, cells, b, world->media[b].span, CML_SAFE_ABOVE);
    }
}
