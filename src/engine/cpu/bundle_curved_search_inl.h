/* Code, included by bundle_walk_inl.h only: lanes near curved boundaries, step 2. It finds the ring or facet
 * that each lane meets, mostly lane by lane, because each lane walks through other rings, or other nodes of a
 * tree.
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_curved_cross_inl.h"
#include "engine/cpu/bundle_curved_reach_inl.h"
#include "surface/mesh/mesh_surface.h"

/* True if lane i can go the fast way of cml_intersect_lane. It is in the material, and can meet this boundary
 * only, which is curved and smooth and has no backing. Facets are not scored. It has had boundary events, so
 * it is not the beam itself (P1). It is far from the limits of P9, interacts at a finite distance, and its
 * direction is a number. All other lanes go by kernels/walk.h. */
static int cml_is_common_case(const struct cml_flight *f, int i, int boundary)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    const int medium = b->medium[i];
    return medium > 0 && medium <= f->world->setup.num_layers &&
           f->world->surfaces[boundary].kind != CML_SURFACE_PLANE &&
           !f->world->surfaces[boundary].rough.kind && !f->to.facets && !cml_is_touched(f->world, boundary) &&
           b->boundary_events[i] > 0 && b->bounces[i] < CML_TRAPPED_LIMIT && b->s[i] < CML_INFINITY &&
           cml_dot(u, u) < 2;
}

/* Returns the primitive of a boundary that the lane's packet stands on, or CML_NEAR_FACETS; -1: none. */
static int cml_lane_on_primitive(const struct cml_bundle *b, int i, int boundary)
{
    const int on_surface = b->interactions_at_hit[i] == b->interactions[i] && b->on_boundary[i] == boundary;
    return on_surface ? b->on_primitive[i] : -1;
}

/* Adds lane i, whose packet hits the primitive, to the gathered hits of a boundary. p: in the frame of the
 * boundary, where its path begins or where it hits. Returns its number among the hits. */
static int cml_add_hit(const struct cml_bundle *b, int i, int primitive, struct cml_vec p, struct cml_hits *h)
{
    const int k = h->count++;
    h->lane[k] = i;
    h->primitive[k] = primitive;
    h->x[k] = p.x;
    h->y[k] = p.y;
    h->z[k] = p.z;
    h->ux[k] = b->ux[i];
    h->uy[k] = b->uy[i];
    h->uz[k] = b->uz[i];
    h->index_low[k] = b->index_low[i];
    h->index_high[k] = b->index_high[i];
    h->crossings[k] = b->crossings[i];
    h->reflection[k] = b->crossings[i] == 0u ? b->reflection[i] : b->second_reflection[i];
    return k;
}

/* Finds the ring that lane i meets: cml_intersect_field up to the bracketed root. The number of steps from
 * ring to ring differs by lane, so this goes lane by lane. A vector loop finds the root within the ring
 * (cml_hits_refine_rings). p: in the boundary's frame; s: the part of the path to search. */
static void cml_march_lane(struct cml_flight *f, int i, int boundary, struct cml_vec p, real side,
                           struct cml_interval s, struct cml_hits *h)
{
    const struct cml_world *world = f->world;
    const struct cml_bundle *b = f->b;
    const struct cml_rings rings = cml_rings_of(world, boundary);
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    const int on_ring = cml_lane_on_primitive(b, i, boundary);
    const real t_min = on_ring >= 0 ? (real)0 : s.from;
    struct cml_cone_march march =
        cml_cone_begin(rings, cml_from_scene_axis(world, p), u, side, t_min, on_ring);
    const enum cml_cone_verdict verdict = cml_cone_go(rings, &march, s.to, 1, &h->t[h->count]);
    if (verdict == CML_CONE_MISSED) {
        cml_lane_misses(f, i);
        return;
    }
    const int k = cml_add_hit(b, i, march.ring, p, h);
    h->known[k] = verdict == CML_CONE_HIT;
    h->ring_r[k] = rings.r[march.ring];
    h->ring_z[k] = rings.z[march.ring];
    h->ring_end[k] = cml_ring_end(rings, march.ring);
    h->slope[k] = rings.slope[march.ring];
    h->t0[k] = march.t0;
    h->t1[k] = march.t1;
    h->t_max[k] = s.to;
}

/* True if normals are interpolated between vertices. Then P5 has cases that the vector loop does not
 * handle. */
static int cml_has_shading_normal(const struct cml_hit *hit)
{
    return hit->normal.x != hit->facet.x || hit->normal.y != hit->facet.y;
}

/* Finds the facet that lane i meets. p: in the boundary's frame; t_max: length of its path, cm. */
static void cml_query_lane(struct cml_flight *f, int i, int boundary, struct cml_vec p, real side, real t_max,
                           struct cml_hits *h)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    struct cml_hit hit = {.boundary = boundary};
    int near_facet;
    const int found =
        cml_intersect_mesh(f->world, boundary, p, u, side, t_max, cml_lane_on_primitive(b, i, boundary),
                           b->undeflected[i], &hit, &near_facet);
    if (!found && near_facet) {
        cml_process_lane(f, i);
    } else if (!found) {
        cml_lane_misses(f, i);
    } else if (cml_has_shading_normal(&hit)) {
        cml_process_found_hit(f, i, &hit);
    } else {
        const int k = cml_add_hit(b, i, hit.primitive, hit.point, h);
        h->t[k] = hit.t;
        h->doubtful[k] = 0;
        h->normal_x[k] = hit.normal.x;
        h->normal_y[k] = hit.normal.y;
        h->normal_z[k] = hit.normal.z;
    }
}

/* Finds the crossing of lane i with one curved boundary, the only one that it can meet. */
static void cml_intersect_lane(struct cml_flight *f, int i, int boundary, real side, struct cml_interval s,
                               struct cml_hits *h)
{
    const struct cml_bundle *b = f->b;
    const real depth = side < 0 ? f->world->media[boundary].span : (real)0;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i] - depth};
    if (f->world->surfaces[boundary].kind == CML_SURFACE_CONE)
        cml_march_lane(f, i, boundary, p, side, s, h);
    else
        cml_query_lane(f, i, boundary, p, side, s.to, h);
}

/* Returns the parts of the scene that the rays of gathered lanes share when they ask a boundary. grid is NULL
 * if vector loops cannot answer them. */
static struct cml_grid_view cml_view_grid(const struct cml_world *world, int boundary, real side)
{
    struct cml_grid_view view = {.grid = NULL};
    if (boundary < 0 || boundary > world->setup.num_layers) return view;
    const struct cml_surface *surface = &world->surfaces[boundary];
    if (surface->kind != CML_SURFACE_MESH) return view;
    view.grid = cml_mesh_surface_grid(world->meshes[boundary], &view.centred);
    view.depths = &surface->depths;
    view.horizons = side > 0 ? world->horizon_below : world->horizon_above;
    view.depth = side < 0 ? world->media[boundary].span : (real)0;
    view.x0 = world->setup.x0;
    view.y0 = world->setup.y0;
    view.side = side;
    return view;
}

/* Gathers the rays of the lanes that ask a mesh: bit k of `asking` is the k-th gathered lane. */
static void cml_gather_rays(struct cml_gathered *c, real depth, uint64_t asking,
                            const struct cml_intervals *ahead)
{
    struct cml_grid_lanes *l = &c->rays;
    l->count = 0;
    for (; asking; asking &= asking - 1) {
        const int k = __builtin_ctzll(asking), at = l->count++;
        l->lane[at] = c->lane[k];
        l->x[at] = c->x[k];
        l->y[at] = c->y[k];
        l->z[at] = c->z[k] - depth;
        l->ux[at] = c->ux[k];
        l->uy[at] = c->uy[k];
        l->uz[at] = c->uz[k];
        l->s[at] = ahead->to[k];
    }
}

/* Handles the answer to the k-th ray: a hit, a miss, or a search of its own if vector loops could not
 * decide. */
static void cml_take_answer(struct cml_flight *f, int boundary, real side, const struct cml_grid_lanes *l,
                            int k, struct cml_hits *h)
{
    const int i = l->lane[k];
    const struct cml_vec p = {l->x[k], l->y[k], l->z[k]}, at = {l->at_x[k], l->at_y[k], l->at_z[k]};
    if (l->answer[k] == CML_GRID_UNDECIDED) {
        cml_query_lane(f, i, boundary, p, side, l->s[k], h);
    } else if (l->answer[k] == CML_GRID_MISSED) {
        cml_lane_misses(f, i);
    } else {
        const int n = cml_add_hit(f->b, i, l->primitive[k], at, h);
        h->t[n] = l->t[k];
        h->doubtful[n] = 0;
        h->normal_x[n] = l->normal_x[k];
        h->normal_y[n] = l->normal_y[k];
        h->normal_z[n] = l->normal_z[k];
    }
}

/* Asks a mesh for the hits of gathered lanes whose packets stand on nothing, all together. */
static void cml_ask_grid(struct cml_flight *f, int boundary, const struct cml_grid_view *view,
                         uint64_t asking, const struct cml_intervals *ahead, struct cml_hits *h)
{
    struct cml_grid_lanes *l = &f->gathered->rays;
    if (!asking) return;
    cml_gather_rays(f->gathered, view->depth, asking, ahead);
    cml_grid_lanes_ask(view, l);
    for (int k = 0; k < l->count; k++) cml_take_answer(f, boundary, view->side, l, k, h);
}

/* Continues lane i, the k-th gathered. Most lanes meet nothing and interact; the others go by
 * kernels/walk.h. */
static void cml_continue_gathered(struct cml_flight *f, int i, int k)
{
    const struct cml_gathered *c = f->gathered;
    struct cml_bundle *b = f->b;
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    if (!(c->above.meets[k] | c->below.meets[k]) && b->s[i] < CML_INFINITY && cml_dot(u, u) < 2) {
        b->task[i] = CML_LANE_INTERACT;
        return;
    }
    const struct cml_boundary_intervals intervals = {cml_interval_of(&c->above, k),
                                                     cml_interval_of(&c->below, k), 0, b->s[i]};
    cml_continue_lane(f, i, intervals, b->s[i]);
}

/* Does all steps for lanes of one medium: intervals, then the search, many lanes at a time or lane by lane,
 * then the hits of both boundaries. */
static void cml_intersect_gathered(struct cml_flight *f, int medium, uint64_t lanes)
{
    struct cml_gathered *gathered = f->gathered;
    const struct cml_grid_view above_view = cml_view_grid(f->world, medium - 1, 1),
                               below_view = cml_view_grid(f->world, medium, -1);
    uint64_t asking_above = 0, asking_below = 0;
    int k = 0;
    CML_HOOK_BEGIN(CML_HOOK_INTERVALS);
    cml_gather_intervals(f, medium, lanes);
    CML_HOOK_END(CML_HOOK_INTERVALS);
    for (uint64_t rest = lanes; rest; rest &= rest - 1, k++) {
        const int i = __builtin_ctzll(rest);
        const int above = gathered->above.meets[k], below = gathered->below.meets[k],
                  boundary = above ? medium - 1 : medium;
        gathered->lane[k] = i;
        if (above == below || !cml_is_common_case(f, i, boundary))
            cml_continue_gathered(f, i, k);
        else if ((above ? &above_view : &below_view)->grid && cml_lane_on_primitive(f->b, i, boundary) == -1)
            *(above ? &asking_above : &asking_below) |= UINT64_C(1) << k;
        else if (above)
            cml_intersect_lane(f, i, boundary, 1, cml_interval_of(&gathered->above, k),
                               &gathered->hits_above);
        else
            cml_intersect_lane(f, i, boundary, -1, cml_interval_of(&gathered->below, k),
                               &gathered->hits_below);
    }
    cml_ask_grid(f, medium - 1, &above_view, asking_above, &gathered->above, &gathered->hits_above);
    cml_ask_grid(f, medium, &below_view, asking_below, &gathered->below, &gathered->hits_below);
    CML_HOOK_BEGIN(CML_HOOK_HITS);
    cml_process_hits(f, medium, 1, &gathered->hits_above);
    cml_process_hits(f, medium, -1, &gathered->hits_below);
    CML_HOOK_END(CML_HOOK_HITS);
}

/* Handles a lane that heads away from the curved boundary that it is near, and can meet no other before it
 * interacts. It interacts if it rises above its horizon. Most lanes do, and need not wait for others. */
static void cml_check_horizon(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i]}, u = {b->ux[i], b->uy[i], b->uz[i]};
    const int boundary = b->medium[i] - (u.z > 0);
    const real side = u.z > 0 ? (real)1 : (real)-1;
    const real horizon =
        cml_horizon(f->world, &f->world->surfaces[boundary], p, side, cml_lane_on_primitive(b, i, boundary));
    b->task[i] = cml_heads_away(horizon, u, side) ? CML_LANE_INTERACT : CML_LANE_MAY_HIT_CURVED;
}

/* Processes lanes that may hit a curved boundary. They wait for others, as lanes at planes do
 * (cml_process_planes), because the vector loops take as long for few lanes. Then media are processed one by
 * one, that of the lowest lane first. Lanes of a pencil beam above a boundary whose hit is known need no
 * search. */
static void cml_process_curved(struct cml_flight *f)
{
    const int limit = f->b->lanes == CML_LANES ? 32 : 1;
    cml_for_lanes(f, cml_lanes_equal(f->b->task, CML_LANE_MAY_RETURN), cml_check_horizon);
    uint64_t lanes = cml_lanes_equal(f->b->task, CML_LANE_MAY_HIT_CURVED);
    f->wait_at_curved += __builtin_popcountll(lanes);
    if (f->wait_at_curved < limit) return;
    f->wait_at_curved = 0;
    while (lanes) {
        const int medium = f->b->medium[__builtin_ctzll(lanes)];
        const uint64_t here = lanes & cml_lanes_equal(f->b->medium, medium);
        if (f->first_hit_known && medium == 0)
            cml_for_lanes(f, here, cml_process_lane);
        else
            cml_intersect_gathered(f, medium, here);
        lanes &= ~here;
    }
}
