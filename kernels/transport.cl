/* The walk of walk.h on an OpenCL device. Every work-item flies CML_LANES packets (1 on a GPU), takes the next index
 * from a counter that all share when a packet ends, and stops after a bounded number of events; its packets wait in
 * global memory for the next launch.
 * SPDX-License-Identifier: MIT */
#include "score.h"

CML_FN int cml_take(__global struct cml_control *control, cml_u64 *index)
{
    if (*(volatile __global cml_u32 *)&control->taken >= control->count) return 0; /* count stays small */
    const cml_u32 taken = atomic_inc(&control->taken);
    *index = control->first + taken;
    return taken < control->count;
}

CML_FN void cml_write_fate(const struct cml_packet *packet, __global struct cml_device_fate *fate)
{
    fate->absorbed = packet->absorbed;
    fate->fate = packet->fate;
    fate->cause = packet->cause;
    fate->w = packet->w;
    fate->interactions = packet->interactions;
    fate->boundary_events = packet->boundary_events;
    fate->exit_x = packet->exit_x;
    fate->exit_y = packet->exit_y;
    fate->u = packet->u;
}

/* Whether the item can do anything in this launch. */
CML_FN int cml_has_work(__global struct cml_control *control, __global const struct cml_packet *saved)
{
    for (int lane = 0; lane < CML_LANES; lane++)
        if (saved[lane].fate == CML_FATE_ALIVE) return 1;
    return *(volatile __global cml_u32 *)&control->taken < control->count;
}

/* The directions and next flights of a work-item's packets, apart from them so that a CPU turns and draws for all
 * lanes in vectors. */
struct cml_flights {
    cml_u32 index_low[CML_LANES], index_high[CML_LANES], event[CML_LANES];
    cml_u32 turn[CML_LANES]; /* the packet has interacted: by words 1 and 2 of its block, with g */
    real g[CML_LANES], ux[CML_LANES], uy[CML_LANES], uz[CML_LANES];
    cml_u32 w0[CML_LANES], w1[CML_LANES], w2[CML_LANES], w3[CML_LANES];
    real tau[CML_LANES];
};

#ifdef CML_DOUBLE
typedef double2 real2;
#else
typedef float2 real2;
#endif

#if CML_LANES > 1
#define CML_VECTOR static __attribute__((noinline)) /* by itself the loop is made a vector loop */
#else
#define CML_VECTOR CML_FN
#endif

CML_VECTOR void cml_turn_flights(struct cml_flights *restrict f)
{
    for (int i = 0; i < CML_LANES; i++) {
        const struct cml_vec u = {f->ux[i], f->uy[i], f->uz[i]};
        const struct cml_vec v = cml_scatter(u, f->g[i], f->w1[i], f->w2[i]);
        f->ux[i] = f->turn[i] ? v.x : u.x;
        f->uy[i] = f->turn[i] ? v.y : u.y;
        f->uz[i] = f->turn[i] ? v.z : u.z;
    }
}

/* A packet whose last event was no interaction draws the block that it has. */
CML_VECTOR void cml_draw_flights(struct cml_stream stream, struct cml_flights *restrict f)
{
    for (int i = 0; i < CML_LANES; i++) {
        const struct cml_block draw = cml_threefry(stream, f->index_low[i], f->index_high[i], f->event[i],
                                                   (cml_u32)CML_PURPOSE_INTERACTION);
        f->tau[i] = -cml_log(cml_uniform(draw.w[0]));
        f->w0[i] = draw.w[0];
        f->w1[i] = draw.w[1];
        f->w2[i] = draw.w[2];
        f->w3[i] = draw.w[3];
    }
}

CML_FN void cml_ask_flight(const struct cml_world *world, const struct cml_packet *packet, int lane,
                           struct cml_flights *f)
{
    f->index_low[lane] = (cml_u32)packet->index;
    f->index_high[lane] = (cml_u32)(packet->index >> 32);
    f->event[lane] = packet->interactions;
    f->turn[lane] = packet->tau < 0 && packet->interactions > 0;
    f->g[lane] = world->media[packet->medium].g;
    f->ux[lane] = packet->u.x;
    f->uy[lane] = packet->u.y;
    f->uz[lane] = packet->u.z;
    f->w1[lane] = packet->draw.w[1];
    f->w2[lane] = packet->draw.w[2];
}

CML_FN void cml_take_flight(struct cml_stream stream, const struct cml_flights *f, int lane,
                            struct cml_packet *packet)
{
    const struct cml_block draw = {{f->w0[lane], f->w1[lane], f->w2[lane], f->w3[lane]}};
    vstore2((real2)(f->ux[lane], f->uy[lane]), 0, &packet->u.x); /* x and y are read together: so write them */
    packet->u.z = f->uz[lane];
    packet->draw = draw;
    if (packet->tau >= 0) return;
    packet->tau =
        draw.w[0] ? f->tau[lane] : cml_optical_depth(stream, packet->index, packet->interactions, 0u);
}

/* The packet's end into the tallies, and the next packet in its place if there is one. */
CML_FN void cml_replace(const struct cml_world *world, const struct cml_deposits *to, struct cml_launch launch,
                        __global struct cml_device_fate *fates, struct cml_packet *packet)
{
    cml_u64 index;
    cml_score(&world->setup, packet, to);
    if (launch.record) cml_write_fate(packet, fates + (packet->index - to->control->first));
    if (cml_take(to->control, &index)) cml_launch(world, index, packet);
}

/* One event of one packet. */
CML_FN void cml_advance(const struct cml_world *world, const struct cml_deposits *to, struct cml_launch launch,
                        __global struct cml_device_fate *fates, struct cml_packet *packet)
{
    if (cml_dot(packet->u, packet->u) < 2)
        cml_step(world, to, packet);
    else
        cml_lose(packet, CML_LOST_NAN);
    if (packet->fate != CML_FATE_ALIVE) cml_replace(world, to, launch, fates, packet);
}

/* The events of one work-item in one launch. */
CML_FN void cml_fly(const struct cml_world *world, const struct cml_deposits *to, struct cml_launch launch,
                    __global struct cml_packet *saved, __global struct cml_device_fate *fates)
{
    struct cml_packet packets[CML_LANES];
    struct cml_flights flights;
    cml_u32 alive = 0;
    for (int lane = 0; lane < CML_LANES; lane++) {
        cml_u64 index;
        packets[lane] = saved[lane];
        if (packets[lane].fate != CML_FATE_ALIVE && cml_take(to->control, &index))
            cml_launch(world, index, &packets[lane]);
        cml_ask_flight(world, &packets[lane], lane, &flights);
    }
    for (cml_u32 step = 0; step <= launch.steps; step++) {
        alive = 0;
        cml_turn_flights(&flights);
        cml_draw_flights(world->setup.stream, &flights);
        for (int lane = 0; lane < CML_LANES; lane++) {
            struct cml_packet *packet = &packets[lane];
            if (packet->fate != CML_FATE_ALIVE) continue;
            cml_take_flight(world->setup.stream, &flights, lane, packet);
            if (step < launch.steps) cml_advance(world, to, launch, fates, packet);
            cml_ask_flight(world, packet, lane, &flights);
            alive += packet->fate == CML_FATE_ALIVE;
        }
        if (!alive) break;
    }
    for (int lane = 0; lane < CML_LANES; lane++) saved[lane] = packets[lane];
    if (alive) atomic_add(&to->control->alive, alive);
}

__kernel __attribute__((reqd_work_group_size(CML_GROUP_SIZE, 1, 1))) void
cml_transport(const struct cml_setup setup, const struct cml_windows windows, const struct cml_launch launch,
              __global const struct cml_medium *media, __global const struct cml_surface *surfaces,
              __global const real *rings, __global const real *clearance, __global struct cml_control *control,
              __global struct cml_packet *packets, __global struct cml_device_fate *fates,
              __global cml_u64 *cells, __local cml_u64 *near)
{
    const struct cml_world world = {setup,
                                    media,
                                    surfaces,
                                    rings,
                                    rings + launch.rings,
                                    rings + 2 * launch.rings,
                                    clearance,
                                    clearance + launch.clearance_cells};
    const struct cml_deposits to = {windows, near, cells, control};
    const size_t item = get_global_id(0);
#if CML_GROUP_SIZE == 1 /* else the others of the group may need the local memory */
    if (!cml_has_work(control, packets + item * CML_LANES)) return;
#endif
    cml_clear_near(near, launch.near_cells);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < launch.items) cml_fly(&world, &to, launch, packets + item * CML_LANES, fates);
    barrier(CLK_LOCAL_MEM_FENCE);
    cml_flush_window(&to, windows.sums);
    cml_flush_window(&to, windows.reflected);
    cml_flush_window(&to, windows.transmitted);
    cml_flush_window(&to, windows.absorbed);
}

/* The device's sizes and offsets, for the host to compare with its own. */
__kernel void cml_layout(__global cml_u32 *out)
{
    const cml_u32 layout[CML_LAYOUT_ENTRIES] = CML_LAYOUT;
    for (int i = 0; i < CML_LAYOUT_ENTRIES; i++) out[i] = layout[i];
}
