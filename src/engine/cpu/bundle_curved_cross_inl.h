/* Code, included by bundle_curved_search_inl.h only: lanes near curved boundaries, step 4. The gathered hits
 * go back into the lanes, into the next medium, or out of the scene.
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_lane_events_inl.h"
#include "engine/cpu/bundle_curved_hits_inl.h"

/* Flies the lane's packet on in outer medium `to`, where it may meet the boundary again, by kernels/walk.h
 * until it is back or gone (P6). */
static void cml_continue_lane_outside(struct cml_flight *f, int i, int to)
{
    struct cml_packet packet;
    cml_lane_packet(f->b, i, &packet);
    cml_end_visit(f->world, &packet);
    packet.medium = to;
    cml_count_depth(f->world, &packet);
    cml_fly_outside(f, &packet);
    cml_return_to_lane(f, i, &packet);
}

/* True if a packet that has gone through a primitive of a boundary at p into outer medium `to`, in direction
 * u, cannot come back. Either packets outside are not followed (P6), or the packet rises above its horizon in
 * a clear medium. Most packets that leave do, and need no search. */
static int cml_never_returns(const struct cml_world *world, int boundary, int primitive, int to,
                             struct cml_vec p, struct cml_vec u)
{
    const real side = to > boundary ? (real)1 : (real)-1;
    const real horizon = cml_horizon(world, &world->surfaces[boundary], p, side, primitive);
    return !world->setup.reentry ||
           (!(world->media[to].mfp < CML_INFINITY) && cml_heads_away(horizon, u, side));
}

/* Ends the lane's packet, which has left the material for good at p in direction u, into outer medium `to`.
 * p: cm from the scene's origin. The lane has not counted this boundary event yet. The packet had entered, so
 * it is not specular. */
static void cml_end_lane_outside(struct cml_flight *f, int i, int to, int primitive, struct cml_vec p,
                                 struct cml_vec u)
{
    const struct cml_bundle *b = f->b;
    if (b->stay) cml_leave_lane(f, i, to, p.z);
    const struct cml_termination end = {
        .index = cml_lane_index(b, i),
        .fate = cml_fate_outside(1, to == 0),
        .cause = CML_LOST_NOT,
        .w = b->w[i],
        .interactions = b->interactions[i],
        .boundary_events = b->boundary_events[i] + 1,
        .exit_x = p.x,
        .exit_y = p.y,
        .exit_z = p.z,
        .ux = u.x,
        .uy = u.y,
        .uz = u.z,
        .path = b->path[i],
        .primitive = primitive,
        .trail = cml_lane_trail(b, i),
    };
    if (f->to.phi) {
        const struct cml_stretch last = {end.index, p,       u, to, end.interactions + end.boundary_events,
                                         end.w,     end.path};
        (void)cml_mark_far(f->world, &f->to, &last, b->mark[i], CML_INFINITY);
    }
    cml_push_termination(f, i, end);
}

/* Does a boundary event for the k-th of the gathered hits, as cml_boundary_event does. The new direction is
 * known; the packet goes into medium `other` if it went through, otherwise it stays in its own. undeflected:
 * the indices are equal, so all packets go through (P5) and draw nothing. */
static void cml_lane_boundary_event(struct cml_flight *f, const struct cml_hits *h, int k, int boundary,
                                    int other, int undeflected)
{
    const struct cml_world *world = f->world;
    struct cml_bundle *b = f->b;
    const int i = h->lane[k], from = b->medium[i], through = undeflected || h->through[k];
    const int to = through ? other : from, on_surface = b->interactions_at_hit[i] == b->interactions[i];
    const real left = CML_FMA(-h->t[k], CML_OF_MEDIUM(b, mut)[i], b->tau[i]);
    const struct cml_vec p = {h->x[k], h->y[k], h->z[k] + (to == boundary ? world->media[to].span : (real)0)},
                         u = {h->ux[k], h->uy[k], h->uz[k]};
    const int outside = to == 0 || to > world->setup.num_layers;
    if (outside && cml_never_returns(world, boundary, h->primitive[k], to, p, u)) {
        cml_end_lane_outside(f, i, to, h->primitive[k], p, u);
        return;
    }
    cml_store_ray(b, i, p, u);
    b->tau[i] = left > 0 ? left : (real)0;
    b->bounces[i] = (on_surface ? b->bounces[i] : 0) + 1;
    b->interactions_at_hit[i] = b->interactions[i];
    b->crossings[i] += (cml_u32)!undeflected;
    b->boundary_events[i]++;
    b->on_boundary[i] = boundary;
    b->on_primitive[i] = h->primitive[k];
    b->undeflected[i] = undeflected;
    b->task[i] = CML_LANE_TO_FLY;
    if (to == from) {
        if (b->stay) cml_count_lane_depth(b, i, p.z);
        return;
    }
    if (outside) {
        cml_continue_lane_outside(f, i, to);
        return;
    }
    if (b->stay) cml_end_lane_visit(f, i);
    cml_flush_deposits(f, i);
    b->medium[i] = to;
    if (b->stay) cml_count_lane_depth(b, i, p.z);
    cml_load_medium(f, i);
}

/* Counts the optical paths to the hits (P11), in a medium of index n. Doubtful hits are left out, because
 * kernels/walk.h does them again. */
static void cml_count_hit_paths(struct cml_bundle *b, const struct cml_hits *h, real n)
{
    for (int k = 0; k < h->count; k++) {
        real *path = &b->path[h->lane[k]], *here = &b->here[h->lane[k]];
        if (h->doubtful[k]) continue;
        *here = cml_here_after(*here, *path, h->t[k]);
        *path = cml_path_after(*path, h->t[k], n);
    }
}

/* Scores the marks of fluence up to the hits (P14), except for doubtful ones. */
static void cml_mark_to_hits(struct cml_flight *f, const struct cml_hits *h)
{
    for (int k = 0; k < h->count; k++) {
        const int i = h->lane[k];
        if (h->doubtful[k]) continue;
        const struct cml_stretch s = cml_lane_stretch(f->b, i);
        f->b->mark[i] = cml_mark_stretch(f->world, &f->to, &s, f->b->mark[i], h->t[k]);
    }
}

/* Processes the gathered hits of one boundary: roots and directions in vector loops, then lane by lane back
 * into the bundle. Doubtful hits are done again by kernels/walk.h. Leaves no hits for the next round. */
static void cml_process_hits(struct cml_flight *f, int medium, real side, struct cml_hits *h)
{
    const struct cml_world *world = f->world;
    const int boundary = side > 0 ? medium - 1 : medium, other = side > 0 ? medium - 1 : medium + 1;
    uint64_t *counts = f->tally->count;
    if (h->count == 0) return; /* an outer medium has no boundary, and no medium, beyond one of its sides */
    const real n1 = world->media[medium].n, n2 = world->media[other].n;
    CML_HOOK_BEGIN(CML_HOOK_REFLECT);
    if (world->surfaces[boundary].kind == CML_SURFACE_CONE) cml_hits_refine_rings(world, side, h);
    if (n1 != n2)
        counts[CML_COUNT_SHADING_OVERRULED] +=
            (uint64_t)cml_hits_reflect_or_refract(&world->setup, side, n1, n2, h);
    CML_HOOK_END(CML_HOOK_REFLECT);
    if (f->to.phi && !cml_is_dense(world->setup.marks, world->media[medium].mfp)) cml_mark_to_hits(f, h);
    if (world->setup.keeps_paths) cml_count_hit_paths(f->b, h, n1);
    for (int k = 0; k < h->count; k++) {
        if (h->doubtful[k]) {
            cml_process_lane(f, h->lane[k]);
        } else {
            counts[CML_COUNT_QUERIES]++;
            CML_HOOK_MET(1);
            cml_lane_boundary_event(f, h, k, boundary, other, n1 == n2);
        }
    }
    h->count = 0;
}
