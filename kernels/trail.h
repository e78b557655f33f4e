/* What a packet remembers of its way: time (P11), and, for detectors, path, interactions and depth by medium
 * (P13). SPDX-License-Identifier: MIT */
#pragma once

#include "surface_hit.h"
#include "types.h"

/* P11: a packet's optical path after t more (cm) in a medium of index n. Its clock starts where it touches
 * something for the first time. */
CML_FN real cml_path_after(real path, real t, real n)
{
    return path < 0 ? (real)0 : CML_FMA(t, n, path);
}

/* P13: the length of a visit after t more (cm), which counts from the same place on. */
CML_FN real cml_here_after(real here, real path, real t)
{
    return path < 0 ? here : here + t;
}

/* Before the packet flies t (cm) in the medium it is in. Rows weigh the material only (P16). */
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

/* Keeps the depth that a packet has come to, if it is the largest of this visit of its medium (P13). */
CML_FN void cml_count_depth(const struct cml_world *world, CML_PACKET struct cml_packet *packet)
{
#ifdef __OPENCL_VERSION__
    (void)world, (void)packet;
#else
    if (world->setup.keeps_paths && packet->path >= 0)
        packet->low = packet->p.z > packet->low ? packet->p.z : packet->low;
#endif
}

/* 1 - cosine of the angle between two unit vectors: half the square of their difference, which keeps the
 * digits of small angles. */
CML_FN real cml_one_minus_dot(struct cml_vec u, struct cml_vec v)
{
    const real x = v.x - u.x, y = v.y - u.y, z = v.z - u.z;
    return (real)0.5 * CML_FMA(x, x, CML_FMA(y, y, z * z));
}

/* P13: the packet has been scattered from the direction u into its own. */
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
/* P13: a visit of a medium comes to an end. low: in the medium's frame. */
CML_FN void cml_add_visit(const struct cml_world *world, struct cml_trail *trail, int medium, real here,
                          real low, real momentum, cml_u32 interactions)
{
    const real deep = low + world->media[medium].depth;
    trail->stay[medium].length += (double)here;
    trail->stay[medium].momentum += (double)momentum;
    trail->stay[medium].interactions += interactions;
    trail->deepest = deep > trail->deepest ? deep : trail->deepest;
}

/* P13: a trail that begins with a packet, or with its lane in a bundle. Where its path says so, the packet
 * has come straight through the first layer, or in an outer medium from a far source. */
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

/* P13: where the first visit begins, frame of the medium. */
CML_FN real cml_first_low(real path, real z)
{
    return path < 0 ? -CML_INFINITY : z;
}
#endif

/* P13: before the packet comes into another medium, and when it has ended. */
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
