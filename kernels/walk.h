/* The life of a photon packet: launch, flight, boundary, interaction, exit. All engines use this one text.
 * The rules that it cites, P1 to P20, stand in samples/manual/physics (p01.md to p20.md).
 *
 *      cml_begin_walk --> cml_step <----------------------+
 *                           |                             |
 *                           +-- cml_score_boundary_event -+    a boundary comes first
 *                           +-- cml_interact -------------+    the optical depth is used up
 *                           +-- cml_leave_scene                nothing is ahead
 *
 * A packet keeps its own part of the weight balance. Deposits are added to the caller's arrays at once. All
 * other results are returned in the packet.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "bins.h"
#include "contact.h"
#include "lattice.h"
#include "optics.h"
#include "rng.h"
#include "rough.h"
#include "source.h"
#include "surface_hit.h"
#include "trail.h"
#include "types.h"

#ifdef __OPENCL_VERSION__
#include "device_deposits.h"
#else
#include "host_deposits.h"
#include "marks.h"
#include "windows.h"
#endif

/* Draws the random words of the next interaction, and the optical depth to it (P2). On a device it only
 * sets the optical depth below 0, which asks the device to draw for many packets together before their
 * next step (device_lanes.h). */
CML_FN void cml_next_flight(const struct cml_world *world, CML_PACKET struct cml_packet *packet)
{
#ifdef __OPENCL_VERSION__
    (void)world;
    packet->tau = -1;
#else
    packet->draw = cml_draw_interaction(world->setup.stream, packet->index, packet->interactions);
    packet->tau =
        cml_optical_depth(world->setup.stream, packet->index, packet->interactions, packet->draw.w[0]);
#endif
}

/* Turns a packet into its new direction (P4). */
CML_FN void cml_scatter_packet(const struct cml_world *world, real g, CML_PACKET struct cml_packet *packet)
{
    packet->u = cml_scatter_in(world->phase_cells, packet->u, g, packet->draw.w[1], packet->draw.w[2]);
    CML_ASSERT(cml_is_unit(packet->u));
}

/* No packet is traced in OpenCL C, where string literals have an address space of their own. */
#ifdef __OPENCL_VERSION__
#define cml_event(world, what, packet) ((void)0)
#else
CML_FN void cml_event(const struct cml_world *world, const char *what,
                      CML_PACKET const struct cml_packet *packet)
{
    if (world->on_event) world->on_event(world->on_event_context, what, packet);
}
#endif

/* Returns the length (cm) of an optical depth; infinite if the mean free path is. */
CML_FN real cml_path(real tau, real mfp)
{
    const real s = tau * mfp;
    return mfp < CML_INFINITY ? s : CML_INFINITY;
}

/* Returns the distance (cm) to the next interaction if no boundary comes first. */
CML_FN real cml_free_path(const struct cml_world *world, CML_PACKET const struct cml_packet *packet)
{
    return cml_path(packet->tau, world->media[packet->medium].mfp);
}

/* Places packet `index` in its beam, and draws its first flight. */
CML_FN void cml_launch(const struct cml_world *world, cml_u64 index, CML_PACKET struct cml_packet *packet)
{
    cml_place(world, index, packet);
    cml_next_flight(world, packet);
    cml_event(world, "launch", packet);
}

/* Adds absorbed weight dw at the packet's place to its layer, voxel, gate and cell of A_rz, as far as they
 * are wanted. */
CML_FN void cml_deposit(const struct cml_world *world, const struct cml_deposits *to,
                        CML_PACKET struct cml_packet *packet, cml_u32 dw)
{
    const struct cml_setup *setup = &world->setup;
    packet->absorbed += dw;
    cml_add_to_layer(to, packet->medium, dw);
    const real bins = world->media[packet->medium].bins;
    if (cml_has_volume(to)) cml_add_to_voxel(to, packet->index, cml_voxel(setup, packet->p, bins), dw);
    if (!setup->tally_absorption) return;
#ifndef __OPENCL_VERSION__
    if (to->A_t) cml_add_to_gate(to, setup->gates, packet->medium, cml_gate(setup->gates, packet->path), dw);
#endif
    const int iz = cml_depth_bin(setup, packet->p.z, bins);
    const int ir = cml_radial_bin(setup, packet->p.x, packet->p.y);
    cml_add_to_cell(to, packet->index, ir * (setup->nz + 2) + iz, dw);
}

/* Plays roulette (P8): with the chance w / weight the packet goes on with `weight`, else it ends. A random
 * word is below 2^32 w / weight with this chance, to one part in 2^32. */
CML_FN void cml_roulette(struct cml_roulette_rule rule, CML_PACKET struct cml_packet *packet)
{
    const cml_u32 w = packet->w, weight = rule.weight ? rule.weight : 10u * w;
    if (w >= rule.below) return;
    if ((cml_u64)packet->draw.w[3] * weight < (cml_u64)w << 32) {
        packet->gained += weight - w;
        packet->w = weight;
        CML_ASSERT(weight <= CML_WEIGHT_ONE);
    } else {
        packet->roulette += w;
        packet->w = 0;
        cml_end_packet(packet, CML_FATE_ABSORBED);
    }
}

/* True if a packet at depth z has slipped through the surface of the body that it is in (P9). */
CML_FN int cml_leaked_from_body(const CML_GLOBAL struct cml_surface *surface, real z)
{
    const real margin =
        (real)0.0009765625 * (surface->highest - surface->lowest) + 16 * CML_EPSILON * CML_FABS(z);
    return z < surface->lowest - margin || z > surface->highest + margin;
}

/* True if a packet at depth z lies beyond the envelope of a boundary of its medium (P9): it has slipped
 * through the boundary. The margin covers rounding. */
CML_FN int cml_leaked(const struct cml_world *world, int medium, real z)
{
    if (cml_is_body(world, medium)) return cml_leaked_from_body(&world->surfaces[medium - 1], z);
    const CML_GLOBAL struct cml_surface *top = &world->surfaces[medium - 1],
                                        *bottom = &world->surfaces[medium];
    const real z_bottom = z - world->media[medium].span;
    const real share = (real)0.0009765625;
    if (!cml_is_plane(world, medium - 1) && z < top->lowest - share * (top->highest - top->lowest)) return 1;
    return !cml_is_plane(world, medium) &&
           z_bottom > bottom->highest + share * (bottom->highest - bottom->lowest);
}

#ifndef __OPENCL_VERSION__
/* True if a path from depth `from` to z in a medium goes down through the tail's level (P15). */
CML_FN int cml_enters_tail(const struct cml_tail *tail, int medium, real from, real z)
{
    return (medium == tail->medium) & (from < tail->z) & (z >= tail->z);
}

/* Scores the expected values of weight w that goes down through the tail's level at the cosine uz > 0
 * (P15). */
CML_FN void cml_score_tail(const struct cml_tail *tail, const struct cml_deposits *to, real uz, cml_u32 w)
{
    const real square = uz * uz, light = (real)w * CML_TAIL_UNIT;
    const struct cml_tail_interval *interval = tail->interval;
    while (!(CML_FMA(interval->ratio, square, interval->rest) > 0) && interval->rest < 0) interval++;
    const real c = CML_SQRT(CML_FMA(interval->ratio, square, interval->rest)),
               at = CML_SQRT(c) * interval->per_root, last = (real)(tail->cells - 1);
    const int cell = (int)(at < last ? at : last);
    const real part = at - (real)cell;
    const float *low =
        tail->response + ((interval - tail->interval) * (tail->cells + 1) + cell) * tail->scores;
    for (int i = 0; i < tail->scores; i++) {
        const real share = CML_FMA(part, (real)low[tail->scores + i] - (real)low[i], (real)low[i]);
        const cml_u64 amount = (cml_u64)CML_FMA(light, share, (real)0.5);
        to->expected[i] += amount;
        if (to->expected_late) to->expected_late[i] += amount;
    }
}
#endif

/* Plays roulette after an interaction (P8), or applies the weight window at the packet's place (P19). */
CML_FN void cml_weigh(const struct cml_world *world, const struct cml_deposits *to,
                      CML_PACKET struct cml_packet *packet)
{
#ifndef __OPENCL_VERSION__
    if (world->windows.cells) {
        const real bins = world->media[packet->medium].bins;
        const int cell = cml_window_cell(world->windows, world->setup.per_dz, packet->p, bins);
        const cml_u32 low = world->windows.low[cell], target = cml_target_weight(low);
        const struct cml_roulette_rule rule = {low, target};
        const cml_u32 w = packet->w;
        cml_roulette(rule, packet);
        if (packet->w > w) packet->spent = cml_spent_after(packet->spent, w, packet->w);
        if (cml_is_heavy(packet->w, low)) cml_split(world, to->branches, packet, target);
        return;
    }
#endif
    (void)to;
    cml_roulette(world->setup.roulette, packet);
}

/* Moves a packet by t (cm) to its interaction (P3, P4, P8): absorption, scattering and roulette. */
CML_FN void cml_interact(const struct cml_world *world, const struct cml_deposits *to,
                         CML_PACKET struct cml_packet *packet, real t)
{
    const CML_GLOBAL struct cml_medium *medium = &world->media[packet->medium];
    const struct cml_vec from = packet->p;
    const real path = packet->path;
    cml_count_path(world, packet, t);
    packet->p = cml_along(from, t, packet->u);
    packet->on_boundary = packet->near_boundary - 1;
    if (packet->near_boundary) packet->on_primitive = CML_NEAR_FACETS;
    packet->bounces = 0;
    if (cml_leaked(world, packet->medium, packet->p.z)) {
        cml_lose_packet(packet, CML_LOST_LEAKED);
        return;
    }
    CML_ASSERT(cml_is_in_layer(world, packet->medium, packet->p, t * packet->u.z));
    cml_mark_interaction(world, to, packet, from, path, t);
#ifndef __OPENCL_VERSION__
    if (to->expected && cml_enters_tail(&world->tail, packet->medium, from.z, packet->p.z))
        cml_score_tail(&world->tail, to, packet->u.z, packet->w);
#endif
    cml_count_depth(world, packet);
    const cml_u32 dw = cml_absorbed_part(packet->w, medium->absorb, packet->draw.w[1], packet->draw.w[2]);
    CML_ASSERT(dw <= packet->w && packet->w <= CML_WEIGHT_ONE);
    packet->w -= dw;
    cml_deposit(world, to, packet, dw);
    const struct cml_vec u = packet->u;
    cml_scatter_packet(world, medium->g, packet);
    cml_count_momentum(world, packet, u);
    packet->interactions++;
    cml_event(world, "interact", packet);
    if (!(cml_dot(packet->u, packet->u) < 2))
        cml_lose_packet(packet, CML_LOST_NAN);
    else
        cml_weigh(world, to, packet);
    if (packet->fate == CML_FATE_ALIVE) cml_next_flight(world, packet);
}

/* Returns the direction behind a boundary: reflected if xi <= R, else refracted. up: normal, pointing up;
 * side: +1 the packet comes from below; *transmitted: 1 if it is refracted. */
CML_FN struct cml_vec cml_boundary_direction(struct cml_vec u, struct cml_vec up, real side, real n1, real n2,
                                             real xi, int *transmitted)
{
    const struct cml_vec against = {-side * up.x, -side * up.y, -side * up.z};
    const real ci = cml_incidence(u, against);
    real ct;
    const real R = cml_fresnel(n1, n2, ci, &ct);
    const struct cml_vec refracted = cml_refract(u, against, n1 / n2, ci, ct),
                         mirrored = cml_reflect(u, against);
    const int through = !(xi <= R);
    const struct cml_vec v = {through ? refracted.x : mirrored.x, through ? refracted.y : mirrored.y,
                              through ? refracted.z : mirrored.z};
    *transmitted = through;
    return v;
}

/* Returns the direction behind a plane z = const, reflected or refracted (P5). */
CML_FN struct cml_vec cml_plane_direction(struct cml_vec u, real n1, real n2, real xi, int *transmitted)
{
    const real size = CML_FABS(u.z), ci = size < 1 ? size : (real)1, ratio = n1 / n2;
    real ct;
    const real R = cml_fresnel(n1, n2, ci, &ct);
    const struct cml_vec bent = {ratio * u.x, ratio * u.y, CML_COPYSIGN(ct, u.z)};
    const struct cml_vec refracted = cml_normalise(bent);
    const int through = !(xi <= R);
    const struct cml_vec v = {through ? refracted.x : u.x, through ? refracted.y : u.y,
                              through ? refracted.z : -u.z};
    *transmitted = through;
    return v;
}

/* Reflects or refracts a packet at a smooth boundary between unequal indices (P5). Returns 1 if it goes
 * through. The direction is found again from the facet's own normal, with the same random number, if it
 * leaves on the wrong side of the facet; if it lies in the facet's plane but for rounding, where neighbouring
 * facets would hold the packet for ever; and after CML_SHADED_LIMIT events in a row, because shading normals
 * may trap light in a groove that facets would let out. A packet beside a tip, which rounding has put before
 * a facet from which it leads away, flies on: mirrored, it would run through that facet. */
CML_FN int cml_reflect_or_refract(const struct cml_world *world, CML_PACKET struct cml_packet *packet,
                                  const struct cml_hit *hit, real side, real n1, real n2)
{
    const real xi = cml_uniform(cml_draw_reflection(world->setup.stream, packet->index, packet->crossings));
    int transmitted;
    packet->crossings++;
    if (cml_is_plane(world, hit->boundary)) {
        packet->u = cml_plane_direction(packet->u, n1, n2, xi, &transmitted);
        return transmitted;
    }
    struct cml_vec u = cml_boundary_direction(packet->u, hit->normal, side, n1, n2, xi, &transmitted);
    const real leaving = side * cml_dot(u, hit->facet);
    const int shaded = hit->normal.x != hit->facet.x || hit->normal.y != hit->facet.y;
    const real least = shaded ? CML_SHADED_LEAST : (real)0;
    if ((transmitted ? leaving < least : leaving > -least) ||
        (shaded && packet->bounces >= CML_SHADED_LIMIT)) {
        u = cml_boundary_direction(packet->u, hit->facet, side, n1, n2, xi, &transmitted);
        if (!transmitted && side * cml_dot(packet->u, hit->facet) < 0) u = packet->u;
        packet->shading_overruled++;
    }
    packet->u = u;
    return transmitted;
}

/* Takes a packet over the facets of a rough boundary (P20) with a backing, or between unequal indices n1 and
 * n2. Returns 1 if it goes through. If an interpolated normal does not face the packet, or sends it to the
 * wrong side, the event is done again about the facet's own normal, with the same random numbers. */
CML_RARE int cml_cross_rough(const struct cml_world *world, CML_PACKET struct cml_packet *packet,
                             const struct cml_hit *hit, real side, real n1, real n2)
{
    const struct cml_backing *backing = cml_backing_at(world, hit->boundary);
    const int shaded = hit->normal.x != hit->facet.x || hit->normal.y != hit->facet.y;
    const struct cml_vec from = packet->u;
    const cml_u32 crossing = packet->crossings++, before = packet->rough_draws;
    if (backing && cml_dot(from, hit->facet) > 0) return 0;
    struct cml_rough_exit exit;
    for (int by_facet = 0;; by_facet = 1) {
        const struct cml_vec up = by_facet ? hit->facet : hit->normal,
                             against = {-side * up.x, -side * up.y, -side * up.z};
        cml_u32 draws = before;
        exit = cml_rough_event(world->setup.stream, packet->index, crossing, &draws,
                               world->surfaces[hit->boundary].rough, from, against, n1, n2, backing);
        if (draws > packet->rough_draws) packet->rough_draws = draws;
        const real leaving = side * cml_dot(exit.u, hit->facet);
        const int wrong = exit.transmitted ? leaving < CML_SHADED_LEAST : leaving > -CML_SHADED_LEAST;
        if (by_facet || !shaded ||
            !(wrong || !(side * cml_dot(from, up) > 0) || packet->bounces >= CML_SHADED_LIMIT))
            break;
        packet->shading_overruled++;
    }
    packet->u = exit.u;
    if (exit.steps >= CML_ROUGH_LIMIT) cml_lose_packet(packet, CML_LOST_ROUGH);
    if (backing) {
        const real kept = exit.stays > 0 ? 1 - exit.stays : 1 + 4 * CML_EPSILON;
        cml_keep(packet, hit->boundary, kept,
                 cml_draw(world->setup.stream, packet->index, CML_PURPOSE_BACKING, crossing));
    }
    return exit.transmitted;
}

/* Ends a packet that has left for good. */
CML_FN void cml_score_exit(CML_PACKET struct cml_packet *packet)
{
    cml_end_packet(packet, (enum cml_fate)cml_fate_outside(packet->entered, packet->medium == 0));
}

/* Decides after a boundary event if a packet outside is gone for good (P6). Its exit is the place where it
 * touched the surface last, because an observer sees the brightness of this point. */
CML_FN void cml_after_boundary(const struct cml_world *world, CML_PACKET struct cml_packet *packet,
                               int boundary)
{
    const int outside = cml_is_outer(world, packet->medium);
    if (outside) {
        packet->exit_x = packet->p.x;
        packet->exit_y = packet->p.y;
    }
    if (!outside)
        packet->entered = 1;
    else if (packet->fate == CML_FATE_ALIVE && (!world->setup.reentry || cml_is_plane(world, boundary)))
        cml_score_exit(packet);
}

/* Counts a boundary event, and ends a packet that total reflection could hold for ever (P9). A packet outside
 * is never trapped: it is on its way out, however long it was inside. */
CML_FN void cml_count_bounce(const struct cml_world *world, CML_PACKET struct cml_packet *packet)
{
    packet->bounces++;
    packet->boundary_events++;
    if (packet->fate != CML_FATE_ALIVE) return;
    if (packet->bounces > CML_TRAPPED_LIMIT && !cml_is_outer(world, packet->medium) &&
        !(world->media[packet->medium].mut > 0))
        cml_end_packet(packet, CML_FATE_TRAPPED);
    else if (packet->bounces > CML_STUCK_LIMIT)
        cml_lose_packet(packet, CML_LOST_STUCK);
}

/* Handles a packet that has reached a boundary: P5, P12 or P20, then P6. */
CML_FN void cml_boundary_event(const struct cml_world *world, CML_PACKET struct cml_packet *packet,
                               const struct cml_hit *hit)
{
    const int from = packet->medium, boundary = hit->boundary;
    /* 1: the packet is below; the boundary is its medium's upper one, or its own body's surface. */
    const int below = from == boundary + 1;
    const int other = below ? world->surfaces[boundary].above : boundary + 1;
    const struct cml_meeting meeting = cml_meeting_at(world, packet, hit, below);
    const real n1 = below ? world->media[from].n : meeting.n_above,
               n2 = below ? meeting.n_above : world->media[other].n;
    const real left = CML_FMA(-hit->t, world->media[from].mut, packet->tau);
    packet->tau = left > 0 ? left : (real)0;
    cml_count_path(world, packet, hit->t);
    packet->on_boundary = boundary;
    packet->on_primitive = hit->primitive;
    if (CML_MAY_HAVE_BODIES && boundary > world->setup.num_layers) packet->off = hit->off;
    packet->undeflected = !meeting.opaque & !meeting.stops & (n1 == n2);
    const real side = below ? (real)1 : (real)-1;
    int transmitted = packet->undeflected;
    if (CML_MAY_BE_ROUGH && !transmitted && world->surfaces[boundary].rough.kind)
        transmitted = cml_cross_rough(world, packet, hit, side, n1, n2);
    else if (meeting.stops)
        cml_stop(packet);
    else if (meeting.opaque)
        cml_turn_back(world, meeting.opaque, packet, hit);
    else if (!transmitted)
        transmitted = cml_reflect_or_refract(world, packet, hit, side, n1, n2);
    CML_ASSERT(cml_is_unit(packet->u));
    if (transmitted) {
        cml_end_visit(world, packet);
        packet->medium = other;
    }
    packet->p = hit->point;
    if (packet->medium == boundary) packet->p.z += world->media[boundary].span;
    cml_count_depth(world, packet);
    cml_after_boundary(world, packet, boundary);
    cml_count_bounce(world, packet);
    cml_event(world, transmitted ? "transmit" : meeting.stops ? "stop" : "reflect", packet);
}

/* Returns the facet of a primitive that was hit. */
CML_FN int cml_facet_index(const struct cml_facet_range *range, int primitive)
{
    const int outer_plane = range->count - 1;
    return range->first + (primitive < outer_plane ? primitive : outer_plane);
}

/* Scores a boundary event on the facet at x, y (P7): weight w came from medium `from` to a primitive of the
 * boundary, and weight `left` went on into medium `other`. */
CML_FN void cml_score_facet(const struct cml_world *world, const struct cml_deposits *to, cml_u64 index,
                            int boundary, int primitive, real x, real y, int from, int other, cml_u32 w,
                            cml_u32 left)
{
    const struct cml_facet_range range = world->surfaces[boundary].facets;
    if (range.count == 0) return;
    if (world->surfaces[boundary].kind == CML_SURFACE_PLANE)
        primitive = (int)cml_map_pixel(&world->setup, x, y);
    const int facet = cml_facet_index(&range, primitive);
    const int came_from_below = from == boundary + 1, went_below = other == boundary + 1;
    cml_add_to_facet(to, index, facet,
                     came_from_below ? CML_FACET_IRRADIANCE_BELOW : CML_FACET_IRRADIANCE_ABOVE, w);
    cml_add_to_facet(to, index, facet, went_below ? CML_FACET_EXITANCE_BELOW : CML_FACET_EXITANCE_ABOVE,
                     left);
}

/* Scores the facets of the planes that a packet has passed before its start (P1). The specular part has
 * left upwards, the rest has gone on. In a clear first layer, light goes to and fro between boundaries 0
 * and 1. Summed over all ways, the weight `between` turns back at boundary 0 from below, and as much at
 * boundary 1 from above. */
CML_FN void cml_score_launch(const struct cml_world *world, const struct cml_deposits *to,
                             CML_PACKET const struct cml_packet *packet)
{
    const CML_GLOBAL struct cml_source *source = cml_source_of(world, packet->index);
    const int passed = source->inside ? 0 : packet->medium;
    const real x = packet->p.x, y = packet->p.y;
    for (int b = 0; b < passed; b++) {
        cml_score_facet(world, to, packet->index, b, 0, x, y, b, b + 1, packet->w, packet->w);
        if (b == 0)
            cml_score_facet(world, to, packet->index, 0, 0, x, y, 0, 0, source->specular, source->specular);
        if (passed == 2)
            cml_score_facet(world, to, packet->index, b, 0, x, y, 1, 1, source->between, source->between);
    }
}

/* Runs cml_boundary_event, and scores the event for fluence, facets and expected values if they are wanted.
 * Light from above that stops scores no facet. */
CML_FN void cml_score_boundary_event(const struct cml_world *world, const struct cml_deposits *to,
                                     CML_PACKET struct cml_packet *packet, const struct cml_hit *hit)
{
    const int from = packet->medium;
    const cml_u32 arriving = packet->w;
    cml_mark_path(world, to, packet, packet->p, packet->path, hit->t);
#ifndef __OPENCL_VERSION__
    if (to->expected && hit->boundary == from &&
        cml_enters_tail(&world->tail, from, packet->p.z, world->media[from].span))
        cml_score_tail(&world->tail, to, packet->u.z, packet->w);
#endif
    cml_boundary_event(world, packet, hit);
    cml_mark_last(world, to, packet);
    if (cml_has_facets(to) && !(from == 0 && packet->fate == CML_FATE_ABSORBED))
        cml_score_facet(world, to, packet->index, hit->boundary, hit->primitive, packet->p.x, packet->p.y,
                        from, packet->medium, arriving, packet->w);
}

/* Ends a packet without a boundary or an interaction ahead (P9): it has left, is level, or is lost. */
CML_FN void cml_leave_scene(const struct cml_world *world, const struct cml_deposits *to,
                            CML_PACKET struct cml_packet *packet)
{
    const real away = packet->medium == 0 ? -packet->u.z : packet->u.z;
    const int outside = cml_is_outer(world, packet->medium);
    if (!(cml_dot(packet->u, packet->u) < 2) || !(cml_dot(packet->p, packet->p) >= 0))
        cml_lose_packet(packet, CML_LOST_NAN);
    else if (outside && away >= 0)
        cml_score_exit(packet);
    else if (packet->u.z == 0 && !cml_is_body(world, packet->medium))
        cml_end_packet(packet, CML_FATE_TRAPPED);
    else
        cml_lose_packet(packet, CML_LOST_NO_SURFACE);
    cml_mark_last(world, to, packet);
}

/* Flies one event of a packet that is alive: a boundary, an interaction, or the end of its flight. */
CML_FN void cml_step(const struct cml_world *world, const struct cml_deposits *to,
                     CML_PACKET struct cml_packet *packet)
{
    const real t_max = cml_free_path(world, packet);
    struct cml_hit hit = {0}; /* filled where it is used, which not every compiler sees */
    const struct cml_boundary_intervals intervals = cml_find_intervals(world, packet, t_max);
    const int found = cml_nearest_hit(world, packet, intervals, &hit);
    if (packet->fate != CML_FATE_ALIVE) return;
    if (found)
        cml_score_boundary_event(world, to, packet, &hit);
    else if (t_max < CML_INFINITY)
        cml_interact(world, to, packet, t_max);
    else
        cml_leave_scene(world, to, packet);
}

/* Launches packet `index`, and scores its launch. */
CML_FN void cml_begin_walk(const struct cml_world *world, const struct cml_deposits *to, cml_u64 index,
                           CML_PACKET struct cml_packet *packet)
{
    cml_launch(world, index, packet);
    if (world->setup.apart) cml_add_specular(to, index, CML_WEIGHT_ONE - packet->w);
    if (cml_has_facets(to)) cml_score_launch(world, to, packet);
    cml_mark_first(world, to, packet);
}

/* Flies the whole life of packet `index`. On return packet->fate is never CML_FATE_ALIVE. */
CML_FN void cml_walk(const struct cml_world *world, const struct cml_deposits *to, cml_u64 index,
                     CML_PACKET struct cml_packet *packet)
{
    cml_begin_walk(world, to, index, packet);
    while (packet->fate == CML_FATE_ALIVE) cml_step(world, to, packet);
    CML_ASSERT(cml_packet_balances(world, packet));
    cml_event(world, "end", packet);
}
