/* The history of a packet: time (P11), and for detectors its path, interactions and depth by medium (P13).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface_hit.h"
#include "types.h"

/* Returns a packet's optical path (P11) after t more (cm) in a medium of index n. A clock that has not
 * started (path below 0) starts now: the packet has touched something for the first time. */
CML_FN real cml_path_after(real path, real t, real n)
{
    return path < 0 ? (real)0 : CML_FMA(t, n, path);
}

/* Returns the length of a visit of a medium (P13) after t more (cm). It counts from the place where the
 * packet's clock starts (path below 0: not yet). */
CML_FN real cml_here_after(real here, real path, real t)
{
    return path < 0 ? here : here + t;
}

/* Counts a flight of t (cm) in the packet's medium; called before the flight. Rows of a sweep (P16) count
 * only paths in the material. */
CML_FN void cml_count_path(const struct cml_world *world, CML_PACKET struct cml_packet *packet, real t)
{
#ifdef __OPENCL_VERSION__
    (void)world, (void)packet, (void)t;
#else
    if (!world->setup.keeps_paths) return;
    packet->here = cml_here_after(packet->here, packet->path, t);
    const int apart = world->rows.count && cml_is_outer(world, packet->medium);
    packet->path = cml_path_after(packet->path, apart ? (real)0 : t, world->media[packet->medium].n);
#endif
}

/* Keeps the packet's depth if it is the largest in this visit of its medium (P13). */
CML_FN void cml_count_depth(const struct cml_world *world, CML_PACKET struct cml_packet *packet)
{
#ifdef __OPENCL_VERSION__
    (void)world, (void)packet;
#else
    if (world->setup.keeps_paths && packet->path >= 0)
        packet->low = packet->p.z > packet->low ? packet->p.z : packet->low;
#endif
}

/* Returns 1 - cosine of the angle between two unit vectors. It is computed as half the square of their
 * difference, which keeps the digits of small angles. */
CML_FN real cml_one_minus_dot(struct cml_vec u, struct cml_vec v)
{
    const real x = v.x - u.x, y = v.y - u.y, z = v.z - u.z;
    return (real)0.5 * CML_FMA(x, x, CML_FMA(y, y, z * z));
}

/* Counts the momentum transfer of a scattering from direction u into the packet's present direction (P13). */
CML_FN void cml_count_momentum(const struct cml_world *world, CML_PACKET struct cml_packet *packet,
                               struct cml_vec u)
{
#ifdef __OPENCL_VERSION__
    (void)world, (void)packet, (void)u;
#else
    if (world->setup.keeps_paths) packet->momentum += cml_one_minus_dot(u, packet->u);
#endif
}

#ifndef __OPENCL_VERSION__
/* Adds a finished visit of a medium to a packet's trail, the record of its path (P13): path length,
 * interactions, momentum transfer. low: largest depth of the visit, in the medium's frame. */
CML_FN void cml_add_visit(const struct cml_world *world, struct cml_trail *trail, int medium, real here,
                          real low, real momentum, cml_u32 interactions)
{
    const real deep = low + world->media[medium].depth;
    trail->stay[medium].length += (double)here;
    trail->stay[medium].momentum += (double)momentum;
    trail->stay[medium].interactions += interactions;
    trail->deepest = deep > trail->deepest ? deep : trail->deepest;
}

/* Begins the trail of a packet, or of a packet in a lane (P13). A path above 0 tells that the packet has
 * already flown: straight through the first layer, or in an outer medium from a far source. */
CML_FN void cml_begin_trail(const struct cml_world *world, struct cml_trail *trail, int medium, real path)
{
    const int media = world->setup.num_layers + 2 + world->setup.num_bodies;
    for (int m = 0; m < media; m++) trail->stay[m] = (struct cml_stay){0};
    trail->deepest = -CML_INFINITY;
    if (path > 0 && cml_is_outer(world, medium))
        trail->stay[medium].length = (double)(path / world->media[medium].n);
    else if (path > 0)
        trail->stay[1].length = (double)world->media[1].span;
}

/* Returns the largest depth at the start of a packet's first visit (P13), in the frame of the medium. A
 * packet whose clock has not started has none yet. */
CML_FN real cml_first_low(real path, real z)
{
    return path < 0 ? -CML_INFINITY : z;
}
#endif

/* Ends the packet's visit of its medium (P13): called before the packet comes into another medium, and when
 * it has ended. */
CML_FN void cml_end_visit(const struct cml_world *world, CML_PACKET struct cml_packet *packet)
{
#ifdef __OPENCL_VERSION__
    (void)world, (void)packet;
#else
    if (!packet->trail.stay) return;
    cml_add_visit(world, &packet->trail, packet->medium, packet->here, packet->low, packet->momentum,
                  packet->interactions - packet->before);
    packet->here = packet->momentum = 0;
    packet->low = -CML_INFINITY;
    packet->before = packet->interactions;
#endif
}
