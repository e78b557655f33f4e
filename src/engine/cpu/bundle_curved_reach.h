/* Lanes near curved surfaces: what they can meet before they interact is asked for many of them in vector
 * loops, a medium at a time. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_CURVED_REACH_H
#define CML_BUNDLE_CURVED_REACH_H

#include "engine/cpu/bundle_lanes.h"
#include "engine/cpu/bundle_curved_hits.h"

/* Where lanes can meet one boundary. */
struct cml_stretches {
    _Alignas(64) int meets[CML_LANES];
    real from[CML_LANES], to[CML_LANES];
};

#define CML_CROWD (CML_LANES + CML_GROUP) /* packing writes whole groups */

/* Lanes of one medium side by side. size: whole vectors; what lies behind the lanes there may be anything. */
struct cml_crowd {
    int size;
    _Alignas(64) real x[CML_CROWD], y[CML_CROWD], z[CML_CROWD], ux[CML_CROWD], uy[CML_CROWD], uz[CML_CROWD];
    real s[CML_CROWD];
    struct cml_stretches above, below;
    struct cml_hits hits_above, hits_below;
};

/* Packs lanes of one medium, in the order of their numbers. */
static void cml_gather_crowd(const struct cml_bundle *b, uint64_t lanes, struct cml_crowd *crowd)
{
    int at = 0;
    for (int first = 0; first < CML_LANES; first += CML_GROUP) {
        const cml_u32 mask = (cml_u32)(lanes >> first) & CML_GROUP_MASK;
        if (!mask) continue;
        cml_group_pack(b->x + first, mask, crowd->x + at);
        cml_group_pack(b->y + first, mask, crowd->y + at);
        cml_group_pack(b->z + first, mask, crowd->z + at);
        cml_group_pack(b->ux + first, mask, crowd->ux + at);
        cml_group_pack(b->uy + first, mask, crowd->uy + at);
        cml_group_pack(b->uz + first, mask, crowd->uz + at);
        cml_group_pack(b->s + first, mask, crowd->s + at);
        at += __builtin_popcount(mask);
    }
    crowd->size = cml_whole_vectors(at);
}

/* As cml_can_meet of a plane. depth: of the plane. */
CML_PASS void cml_crowd_reach_plane(const struct cml_crowd *c, real depth, real side,
                                    struct cml_stretches *ahead)
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

/* As cml_can_meet_curved, without its branches. */
__attribute__((always_inline)) static inline void
cml_crowd_reach_curved(const struct cml_world *world, const struct cml_surface *shared,
                       const struct cml_crowd *c, real depth, real side, struct cml_stretches *ahead,
                       const int rings)
{
    const struct cml_surface surface = *shared;
    const struct cml_clearance *grid = &surface.clearance;
    const real *restrict const bounds = side > 0 ? world->deepest : world->highest;
    const real nearest = side > 0 ? surface.highest : surface.lowest;
    const int size = c->size;
#pragma omp simd
    for (int k = 0; k < size; k++) {
        const struct cml_vec p = {c->x[k], c->y[k], c->z[k] - depth}, u = {c->ux[k], c->uy[k], c->uz[k]};
        const real s = c->s[k], inside = side * (nearest - p.z), away = side * u.z, there = inside / away;
        const int passes = inside < away * s, leads_away = cml_heads_away(surface.steepest, u, side);
        const int misses = ((away < 0) & passes) | ((away >= 0) & ((inside < 0) | leads_away));
        const struct cml_stretch within = {!misses, inside < 0 ? there : (real)0,
                                           (away >= 0) & passes ? there : s};
        const struct cml_vec start = cml_from_scene_axis(world, cml_along(p, within.from, u));
        const struct cml_stretch near = cml_near_stretch(grid, bounds, start, u, side, within, rings);
        ahead->meets[k] = near.meets;
        ahead->from[k] = near.from;
        ahead->to[k] = near.to;
    }
}

CML_PASS void cml_crowd_reach_rings(const struct cml_world *world, const struct cml_surface *surface,
                                    const struct cml_crowd *c, real depth, real side,
                                    struct cml_stretches *ahead)
{
    cml_crowd_reach_curved(world, surface, c, depth, side, ahead, 1);
}

CML_PASS void cml_crowd_reach_mesh(const struct cml_world *world, const struct cml_surface *surface,
                                   const struct cml_crowd *c, real depth, real side,
                                   struct cml_stretches *ahead)
{
    cml_crowd_reach_curved(world, surface, c, depth, side, ahead, 0);
}

/* The medium's boundary `boundary`, if there is one, seen from the side. */
static void cml_crowd_reach(const struct cml_flight *f, int boundary, real depth, real side,
                            struct cml_stretches *ahead)
{
    const struct cml_world *world = f->world;
    if (boundary < 0 || boundary > world->setup.num_layers) {
        memset(ahead->meets, 0, sizeof ahead->meets);
        return;
    }
    const struct cml_surface *surface = &world->surfaces[boundary];
    if (surface->kind == CML_SURFACE_PLANE)
        cml_crowd_reach_plane(f->crowd, depth, side, ahead);
    else if (surface->kind == CML_SURFACE_CONE)
        cml_crowd_reach_rings(world, surface, f->crowd, depth, side, ahead);
    else
        cml_crowd_reach_mesh(world, surface, f->crowd, depth, side, ahead);
}

/* As cml_find_reach, for lanes of one medium. */
static void cml_find_reaches(const struct cml_flight *f, int medium, uint64_t lanes)
{
    struct cml_crowd *crowd = f->crowd;
    cml_gather_crowd(f->b, lanes, crowd);
    cml_crowd_reach(f, medium - 1, 0, 1, &crowd->above);
    cml_crowd_reach(f, medium, f->world->media[medium].span, -1, &crowd->below);
}

static struct cml_stretch cml_stretch_of(const struct cml_stretches *of, int k)
{
    const struct cml_stretch s = {of->meets[k], of->from[k], of->to[k]};
    return s;
}

/* Those of the lanes that are in a medium. */
static uint64_t cml_lanes_in(const struct cml_bundle *b, uint64_t lanes, int medium)
{
    uint64_t mask = 0;
    for (int first = 0; first < CML_LANES; first += CML_GROUP)
        mask |= (uint64_t)cml_group_equal(b->medium + first, medium) << first;
    return lanes & mask;
}

#endif
