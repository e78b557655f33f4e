/* The walk of walk.h as an OpenCL kernel. Every work-item flies CML_DEVICE_LANES packets (1 on a GPU). When a
 * packet ends, the item takes the next index from a counter that all items share. It stops after a bounded
 * number of events, and its packets wait in global memory for the next call of the kernel.
 * SPDX-License-Identifier: MIT */
#include "device_lanes.h"

/* ---- a finished packet's entry into the tallies ---- */

/* Weight balance, counts and exit bins of one packet. On the host src/engine/terminated_packets_inl.h adds
 * these for many packets at once. */

/* Returns the term of the balance to which a finished packet's weight belongs. */
CML_FN enum cml_balance_term cml_balance_term_of(int fate)
{
    return fate == CML_FATE_ABSORBED      ? CML_BALANCE_ROULETTE
           : fate == CML_FATE_REFLECTED   ? CML_BALANCE_REFLECTED
           : fate == CML_FATE_TRANSMITTED ? CML_BALANCE_TRANSMITTED
           : fate == CML_FATE_SPECULAR    ? CML_BALANCE_SPECULAR
           : fate == CML_FATE_TRAPPED     ? CML_BALANCE_TRAPPED
                                          : CML_BALANCE_LOST;
}

/* Adds a finished packet to Rd_ra or Tt_ra by its exit bin, or counts it as trapped or lost by its cause. */
CML_FN void cml_score_fate(const struct cml_setup *setup, CML_PACKET const struct cml_packet *packet,
                           const struct cml_deposits *to)
{
    const struct cml_exit exit =
        cml_exit_of(setup, packet->fate, packet->exit_x, packet->exit_y, packet->u.z, 0);
    if (exit.up | exit.down) {
        cml_add_exit(to, exit.up, exit.r * setup->na + exit.alpha, packet->w);
    } else if (packet->fate == CML_FATE_TRAPPED) {
        cml_add_count(to, CML_COUNT_TRAPPED, 1);
    } else if (packet->fate == CML_FATE_LOST) {
        const int first = (int)CML_COUNT_LOST_NO_SURFACE - (int)CML_LOST_NO_SURFACE;
        cml_add_count(to, (enum cml_count)(first + packet->cause), 1);
        cml_add_lost(to, packet->index);
    }
}

/* Adds the end of a packet to the tallies: where it left, the balance of its weight, and the counts of its
 * events. */
CML_FN void cml_score(const struct cml_setup *setup, CML_PACKET const struct cml_packet *packet,
                      const struct cml_deposits *to)
{
    cml_score_fate(setup, packet, to);
    cml_add_to_balance(to, cml_balance_term_of(packet->fate), packet->w);
    cml_add_to_balance(to, CML_BALANCE_ABSORBED, packet->absorbed);
    cml_add_to_balance(to, CML_BALANCE_GAINED, packet->gained);
    cml_add_to_balance(to, CML_BALANCE_ROULETTE, packet->roulette);
    cml_add_to_balance(to, CML_BALANCE_BACKING, packet->backing);
    cml_add_count(to, CML_COUNT_PHOTONS, 1);
    cml_add_count(to, CML_COUNT_INTERACTIONS, packet->interactions);
    cml_add_count(to, CML_COUNT_BOUNDARY_EVENTS, packet->boundary_events);
    cml_add_count(to, CML_COUNT_QUERIES, packet->queries);
    cml_add_count(to, CML_COUNT_SHADING_OVERRULED, packet->shading_overruled);
}

/* Adds the launched and specular weight of all packets of the group, which all packets have alike, from their
 * number. One item calls it, with a barrier before it. */
CML_FN void cml_score_launches(const struct cml_setup *setup, const struct cml_deposits *to)
{
    const cml_u64 photons = to->local_cells[CML_CELL_COUNT + CML_COUNT_PHOTONS];
    if (!photons) return;
    cml_add_global(to->cells + CML_CELL_BALANCE + CML_BALANCE_LAUNCHED, photons * CML_WEIGHT_ONE);
    cml_add_global(to->cells + CML_CELL_BALANCE + CML_BALANCE_SPECULAR, photons * setup->specular);
}

/* ---- packets of a work-item ---- */

/* Takes the next photon: returns 1 and *index, or 0 if none is left. */
CML_FN int cml_device_take(__global struct cml_counters *counters, cml_u64 *index)
{
    /* Read first, so that `taken` stays small. */
    if (*(volatile __global cml_u32 *)&counters->taken >= counters->count) return 0;
    const cml_u32 taken = atomic_inc(&counters->taken);
    *index = counters->first + taken * counters->stride;
    return taken < counters->count;
}

/* Copies how a packet ended to memory that the host reads, for comparison packet by packet. */
CML_FN void cml_device_write_fate(CML_PACKET const struct cml_packet *packet,
                                  __global struct cml_device_fate *fate)
{
    fate->absorbed = packet->absorbed;
    fate->backing = packet->backing;
    fate->fate = packet->fate;
    fate->cause = packet->cause;
    fate->w = packet->w;
    fate->interactions = packet->interactions;
    fate->boundary_events = packet->boundary_events;
    fate->exit_x = packet->exit_x;
    fate->exit_y = packet->exit_y;
    fate->u = packet->u;
}

/* True if the work-item can do anything in this call: it has a packet alive, or can take a new one. */
CML_FN int cml_device_has_work(__global struct cml_counters *counters,
                               __global const struct cml_packet *saved)
{
    for (int lane = 0; lane < CML_DEVICE_LANES; lane++)
        if (saved[lane].fate == CML_FATE_ALIVE) return 1;
    return *(volatile __global cml_u32 *)&counters->taken < counters->count;
}

/* The packets of a work-item. `lanes` holds the members that change with every step, `packets` the rest, with
 * the weight balance as of the last flush. With one lane the rest stays in global memory, so that a packet
 * between boundaries has the registers to itself (CML_PACKET). */
struct cml_device_flight {
    struct cml_device_lanes lanes;
#if CML_DEVICE_LANES > 1
    struct cml_packet packets[CML_DEVICE_LANES];
#else
    __global struct cml_packet *packets; /* [1] in global memory */
#endif
    cml_u32 alive; /* number of packets alive */
};

/* Counts the weight that the lane has deposited since the last call as absorbed. The deposits belong to
 * the lane's present medium, and are the difference of its weight to that at the last call. So call this
 * function before medium or weight change in another way, and after cml_device_read_lane. */
CML_FN void cml_device_flush_deposits(const struct cml_deposits *to, struct cml_device_flight *f, cml_u32 i)
{
    const cml_u32 deposited = f->lanes.flushed_w[i] - f->packets[i].w;
    if (deposited) cml_add_to_layer(to, f->packets[i].medium, deposited);
    f->packets[i].absorbed += deposited;
    f->lanes.flushed_w[i] = f->packets[i].w;
}

/* Copies the optical properties of the packet's medium into its lane, and the depths between which a packet
 * certainly meets no boundary. */
CML_FN void cml_device_load_medium(const struct cml_world *world, struct cml_device_flight *f, cml_u32 i)
{
    struct cml_device_lanes *l = &f->lanes;
    const int m = f->packets[i].medium, layers = world->setup.num_layers;
    const struct cml_medium medium = world->media[m];
    const int top = m > 0 && m <= layers + 1, bottom = m <= layers;
    const real above = top ? world->surfaces[m - 1].highest : -CML_INFINITY;
    const real below = bottom ? medium.span + world->surfaces[m].lowest : CML_INFINITY;
    l->mfp[i] = medium.mfp;
    l->absorb[i] = medium.absorb;
    l->g[i] = medium.g;
    l->bins[i] = medium.bins;
    l->stop_above[i] = above;
    l->stop_below[i] = below;
    l->start_above[i] = top && cml_is_plane(world, m - 1) ? -CML_INFINITY : above;
    l->start_below[i] = bottom && cml_is_plane(world, m) ? CML_INFINITY : below;
    if (CML_MAY_HAVE_BODIES && medium.body_grid >= 0)
        l->stop_above[i] = CML_INFINITY; /* in a medium with bodies every step is examined */
}

/* Copies a packet's place, direction and optical depth into its lane. */
CML_FN void cml_device_store_ray(struct cml_device_lanes *l, cml_u32 i,
                                 CML_PACKET const struct cml_packet *packet)
{
    l->x[i] = packet->p.x;
    l->y[i] = packet->p.y;
    l->z[i] = packet->p.z;
    l->ux[i] = packet->u.x;
    l->uy[i] = packet->u.y;
    l->uz[i] = packet->u.z;
    l->tau[i] = packet->tau;
}

/* Copies a packet's index, weight and number of interactions into its lane. */
CML_FN void cml_device_store_count(struct cml_device_lanes *l, cml_u32 i,
                                   CML_PACKET const struct cml_packet *packet)
{
    l->index_low[i] = (cml_u32)packet->index;
    l->index_high[i] = (cml_u32)(packet->index >> 32);
    l->w[i] = packet->w;
    l->interactions[i] = packet->interactions;
}

/* Copies a packet's state into its lane, where the loops work on it, together with its medium's
 * properties. */
CML_FN void cml_device_load_lane(const struct cml_world *world, struct cml_device_flight *f, cml_u32 i)
{
    struct cml_device_lanes *l = &f->lanes;
    CML_PACKET const struct cml_packet *packet = &f->packets[i];
    cml_device_store_count(l, i, packet);
    cml_device_store_ray(l, i, packet);
    l->flushed_w[i] = packet->w;
    l->touched[i] = packet->interactions - (packet->bounces == 0);
    l->live[i] = packet->fate == CML_FATE_ALIVE;
    l->path_is_free[i] = 0;
    cml_device_load_medium(world, f, i);
}

/* Copies a lane's state back into its packet. A lane that has interacted since it left its last boundary is
 * no longer on it. */
CML_FN void cml_device_read_lane(struct cml_device_flight *f, cml_u32 i)
{
    const struct cml_device_lanes *l = &f->lanes;
    CML_PACKET struct cml_packet *packet = &f->packets[i];
    const struct cml_vec p = {l->x[i], l->y[i], l->z[i]}, u = {l->ux[i], l->uy[i], l->uz[i]};
    packet->p = p;
    packet->u = u;
    packet->tau = l->tau[i];
    packet->w = l->w[i];
    packet->interactions = l->interactions[i];
    packet->draw.w[3] = l->draw3[i];
    if (l->touched[i] == l->interactions[i]) return;
    packet->on_boundary = -1;
    packet->bounces = 0;
}

/* Copies the packet that cml_device_read_lane has filled back into the lane, after its event. A device with
 * one lane also reloads all it had in registers, so that these are free during the search for a boundary.
 * medium: the packet's medium before the event. */
CML_FN void cml_device_restore_lane(const struct cml_world *world, struct cml_device_flight *f, cml_u32 i,
                                    int medium)
{
    struct cml_device_lanes *l = &f->lanes;
    CML_PACKET const struct cml_packet *packet = &f->packets[i];
    cml_device_store_ray(l, i, packet);
    if (CML_DEVICE_LANES == 1) cml_device_store_count(l, i, packet);
    l->touched[i] = packet->interactions - (packet->bounces == 0);
    if (CML_DEVICE_LANES == 1 || packet->medium != medium) cml_device_load_medium(world, f, i);
}

/* Adds the lane's finished packet to the tallies, and puts the next packet into the lane if there is one. */
CML_FN void cml_device_replace(const struct cml_world *world, const struct cml_deposits *to,
                               struct cml_kernel_call call, __global struct cml_device_fate *fates,
                               struct cml_device_flight *f, cml_u32 i)
{
    CML_PACKET struct cml_packet *packet = &f->packets[i];
    cml_u64 index;
    cml_device_flush_deposits(to, f, i);
    cml_score(&world->setup, packet, to);
    if (call.record)
        cml_device_write_fate(packet, fates + (packet->index - to->counters->first) / to->counters->stride);
    if (cml_device_take(to->counters, &index))
        cml_begin_walk(world, to, index, packet);
    else
        f->alive--;
    cml_device_load_lane(world, f, i);
}

#if CML_DEVICE_LANES > 1
/* Finds the packet's first crossing within t (cm). */
CML_FN int cml_device_nearest_hit(const struct cml_world *world, CML_PACKET struct cml_packet *packet, real t,
                                  struct cml_hit *hit)
{
    return cml_nearest_hit(world, packet, cml_find_intervals(world, packet, t), hit);
}
#else
/* Finds the packet's first crossing, as cml_find_intervals and cml_nearest_hit do. The code contains the
 * search only once, and uses it for the boundary above and then for the one below, because a device with
 * one lane holds only little code at a time. */
CML_FN int cml_device_nearest_hit(const struct cml_world *world, CML_PACKET struct cml_packet *packet, real t,
                                  struct cml_hit *hit)
{
    const int medium = packet->medium, sides = cml_is_body(world, medium) ? 0 : 2;
    real reach = t;
    int found = 0;
    CML_ONE_COPY
    for (int down = 0; down < sides; down++) {
        const int boundary = medium - 1 + down;
        const real side = down ? (real)-1 : (real)1;
        struct cml_vec p = packet->p;
        if (boundary < 0 || boundary > world->setup.num_layers) continue;
        if (down) p.z -= world->media[medium].span;
        struct cml_interval s = cml_surface_interval(world, &world->surfaces[boundary], p, packet->u, side,
                                                     cml_on_primitive(packet, boundary), t);
        s.to = reach < s.to ? reach : s.to;
        if (!s.meets || !cml_intersect_surface(world, packet, boundary, p, side, s, hit)) continue;
        reach = hit->t;
        found = 1;
    }
    if (CML_MAY_HAVE_BODIES && world->setup.num_bodies) {
        struct cml_body_region region;
        const int ahead = cml_may_hit_body(world, medium, packet->p, packet->u, t, &region);
        if (ahead) found |= cml_nearest_body(world, packet, reach, ahead == CML_BODIES_FROM_AFAR, hit);
    }
    return found;
}
#endif

/* Handles what packet i meets within t (cm), the distance to its next interaction: a boundary, or the end of
 * the packet. Returns 1 if it meets nothing and is to interact. */
CML_FN cml_u32 cml_device_event(const struct cml_world *world, const struct cml_deposits *to,
                                struct cml_device_flight *f, cml_u32 i, real t)
{
    CML_PACKET struct cml_packet *packet = &f->packets[i];
    struct cml_hit hit;
    if (!(cml_dot(packet->u, packet->u) < 2)) {
        cml_lose_packet(packet, CML_LOST_NAN);
    } else if (cml_device_nearest_hit(world, packet, t, &hit)) {
        cml_device_flush_deposits(to, f, i);
        cml_score_boundary_event(world, to, packet, &hit);
        f->lanes.w[i] = f->lanes.flushed_w[i] = packet->w; /* a backing may have kept a part of the weight */
    } else if (!(t < CML_INFINITY)) {
        cml_leave_scene(world, to, packet);
    } else if (cml_leaked(world, packet->medium, cml_along(packet->p, t, packet->u).z)) {
        cml_lose_packet(packet, CML_LOST_LEAKED);
    } else {
        return 1;
    }
    return 0;
}

/* Handles the event of a lane that may meet a boundary; the lane may prove to interact instead. Returns 1 if
 * its packet has ended. */
CML_FN cml_u32 cml_device_process_lane(const struct cml_world *world, const struct cml_deposits *to,
                                       struct cml_device_flight *f, cml_u32 i)
{
    CML_PACKET struct cml_packet *packet = &f->packets[i];
    const int medium = packet->medium;
    cml_device_read_lane(f, i);
    CML_FORGET_REGISTERS;
    if (!(packet->tau < CML_INFINITY))
        packet->tau = cml_optical_depth(world->setup.stream, packet->index, packet->interactions, 0u);
    const real t = cml_free_path(world, packet);
    const cml_u32 mine = cml_device_event(world, to, f, i, t);
    cml_device_restore_lane(world, f, i, medium);
    f->lanes.s[i] = t;
    f->lanes.mine[i] = mine;
    return packet->fate != CML_FATE_ALIVE;
}

/* Plays roulette with the lane's packet (P8). Returns 1 if it has ended. */
CML_FN cml_u32 cml_device_roulette(struct cml_roulette_rule rule, const struct cml_deposits *to,
                                   struct cml_device_flight *f, cml_u32 i)
{
    CML_PACKET struct cml_packet *packet = &f->packets[i];
    cml_device_read_lane(f, i);
    cml_device_flush_deposits(to, f, i);
    cml_roulette(rule, packet);
    f->lanes.w[i] = f->lanes.flushed_w[i] = packet->w;
    return packet->fate != CML_FATE_ALIVE;
}

#if CML_DEVICE_LANES > 1
/* Flies one event of every packet. Returns the number of events of each, 1, or 0 if `most` is 0. */
CML_FN cml_u32 cml_device_pass(struct cml_world *world, __local const struct cml_stream *stream,
                               const struct cml_deposits *to, struct cml_kernel_call call,
                               __global struct cml_device_fate *fates, struct cml_device_flight *f,
                               cml_u32 most)
{
    cml_u32 ended = 0;
    world->setup.stream = *stream;
    const cml_u32 may_hit = cml_device_fly(world->setup.stream, &f->lanes);
    for (cml_u32 rest = may_hit; rest; rest &= rest - 1)
        ended |= cml_device_process_lane(world, to, f, CML_LOWEST(rest)) << CML_LOWEST(rest);
    const cml_u32 low_lanes = cml_device_interact(&world->setup, world->phase_cells, &f->lanes);
    if (world->setup.tally_absorption) cml_device_deposit(to, &f->lanes);
    for (cml_u32 rest = low_lanes; rest; rest &= rest - 1)
        ended |= cml_device_roulette(world->setup.roulette, to, f, CML_LOWEST(rest)) << CML_LOWEST(rest);
    for (cml_u32 rest = ended; rest; rest &= rest - 1)
        cml_device_replace(world, to, call, fates, f, CML_LOWEST(rest));
    return most ? 1 : 0;
}
#else
/* Flies at most `most` events of the packet, but at least one, and returns their number. Items of a group
 * wait for each other. So each flies from interaction to interaction, up to a number of them, and all items
 * that have come to a boundary, to roulette or to an end handle it together. A boundary that was looked for
 * and not met is no event: the item goes on to its interaction in the next pass. */
CML_FN cml_u32 cml_device_pass(struct cml_world *world, __local const struct cml_stream *stream,
                               const struct cml_deposits *to, struct cml_kernel_call call,
                               __global struct cml_device_fate *fates, struct cml_device_flight *f,
                               cml_u32 most)
{
    cml_u32 events = 0, may_hit, low = 0, ended = 0;
    do {
        world->setup.stream = *stream;
        may_hit = cml_device_fly(world->setup.stream, &f->lanes);
        if (may_hit) break;
        low = cml_device_interact(&world->setup, world->phase_cells, &f->lanes);
        if (world->setup.tally_absorption) cml_device_deposit(to, &f->lanes);
        events++;
    } while (!low && events < most && events < CML_DEVICE_PASSES);
    if (may_hit) {
        ended = cml_device_process_lane(world, to, f, 0);
        f->lanes.path_is_free[0] = f->lanes.mine[0];
        events += !f->lanes.mine[0];
    }
    if (low) ended = cml_device_roulette(world->setup.roulette, to, f, 0);
    if (ended) cml_device_replace(world, to, call, fates, f, 0);
    return events;
}
#endif

/* Flies the packets of one work-item for one call of the kernel: takes packets from global memory or starts
 * new ones, makes up to call.steps steps with each, and stores the packets and their deposits. stream: a
 * copy of the random stream in the work-group's fast local memory. */
CML_FN void cml_device_work_item(struct cml_world *world, __local const struct cml_stream *stream,
                                 const struct cml_deposits *to, struct cml_kernel_call call,
                                 __global struct cml_packet *saved, __global struct cml_device_fate *fates)
{
    struct cml_device_flight flight;
#if CML_DEVICE_LANES > 1
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++) flight.packets[i] = saved[i];
#else
    flight.packets = saved;
#endif
    flight.alive = 0;
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++) {
        cml_u64 index;
        CML_PACKET struct cml_packet *packet = &flight.packets[i];
        if (packet->fate != CML_FATE_ALIVE && cml_device_take(to->counters, &index))
            cml_begin_walk(world, to, index, packet);
        flight.alive += packet->fate == CML_FATE_ALIVE;
        cml_device_load_lane(world, &flight, i);
    }
    /* A path that is known to be free is flown to its end even beyond call.steps, because the next call
     * would not know that it is free and would search for boundaries again. */
    for (cml_u32 done = 0; flight.alive && (done < call.steps || flight.lanes.path_is_free[0]);)
        done += cml_device_pass(world, stream, to, call, fates, &flight, call.steps - done);
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++) {
        cml_device_read_lane(&flight, i);
        cml_device_flush_deposits(to, &flight, i);
#if CML_DEVICE_LANES > 1
        saved[i] = flight.packets[i];
#endif
    }
    if (flight.alive) atomic_add(&to->counters->alive, flight.alive);
}

/* Values that every pass reads anew from local memory. If they came with the kernel's arguments, a compiler
 * would keep them in registers, with all that follows from them alone. */
struct cml_shared {
    struct cml_local_parts parts;
    struct cml_stream stream;
};

/* The kernel that the host calls: each work-item flies its packets for one call, and the sums in the group's
 * fast local memory are then added to the global ones. */
__kernel __attribute__((reqd_work_group_size(CML_GROUP_SIZE, 1, 1))) void cml_transport(
    const struct cml_setup setup, const struct cml_local_parts parts, const struct cml_kernel_call call,
    __global const struct cml_medium *media, __global const struct cml_surface *surfaces,
    __global const real *ring_r, __global const real *ring_z, __global const real *ring_slope,
    __global const real *ring_horizon_above, __global const real *ring_horizon_below,
    __global const int *ring_starts, __global const real *deepest, __global const real *highest,
    __global const struct cml_body *bodies, __global const struct cml_body_node *body_nodes,
    __global const struct cml_body_grid *body_grids, __global const struct cml_body_cell *body_cells,
    __global const struct cml_phase_cell *phase_cells, __global const struct cml_source *sources,
    __global const struct cml_light_cell *light_cells, __global const cml_u32 *image_words,
    __global struct cml_counters *counters, __global struct cml_packet *packets,
    __global struct cml_device_fate *fates, __global cml_u64 *cells, __local cml_u64 *local_cells)
{
    struct cml_world world = {setup,
                              media,
                              surfaces,
                              ring_r,
                              ring_z,
                              ring_slope,
                              ring_horizon_above,
                              ring_horizon_below,
                              ring_starts,
                              deepest,
                              highest,
                              0,
                              0,
                              bodies,
                              body_nodes,
                              body_grids,
                              body_cells,
                              phase_cells,
                              sources,
                              light_cells,
                              image_words};
    __local struct cml_shared shared;
    const struct cml_deposits to = {&shared.parts, local_cells, cells, counters};
    const size_t item = get_global_id(0);
#if CML_GROUP_SIZE == 1 /* in a larger group the other items may need the local memory */
    if (!cml_device_has_work(counters, packets + item * CML_DEVICE_LANES)) return;
#endif
    if (get_local_id(0) == 0) {
        shared.stream = setup.stream;
        shared.parts = parts;
    }
    cml_zero_local(local_cells, call.num_local);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < call.items)
        cml_device_work_item(&world, &shared.stream, &to, call, packets + item * CML_DEVICE_LANES, fates);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0) cml_score_launches(&world.setup, &to);
    cml_flush_local_part(&to, parts.sums);
    cml_flush_local_part(&to, parts.reflected);
    cml_flush_local_part(&to, parts.transmitted);
    cml_flush_local_part(&to, parts.absorbed);
}

/* Writes the device's sizes and offsets of structs, which the host compares with its own. */
__kernel void cml_layout(__global cml_u32 *out)
{
    const cml_u32 layout[CML_LAYOUT_ENTRIES] = CML_LAYOUT;
    for (int i = 0; i < CML_LAYOUT_ENTRIES; i++) out[i] = layout[i];
}
