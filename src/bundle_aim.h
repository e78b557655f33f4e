/* Where packets of a pencil beam begin. Those that start above a surface that is no plane all meet it at the
 * same place and angle: both are asked for once (at a vertex of a mesh, where all facets there have their
 * say, it takes long to tell), and so is what becomes of the packets that go through.
 * SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_AIM_H
#define CML_BUNDLE_AIM_H

#include "bundle_lanes.h"

/* What all packets that are not reflected are like behind the first surface; nothing, where that depends on
 * their random numbers, too. */
static void cml_find_entry(struct cml_flight *f)
{
    const struct cml_world *world = f->world;
    const struct cml_hit *hit = &f->first;
    const struct cml_vec against = hit->normal; /* up, and the beam comes down */
    const real n1 = world->media[0].n, n2 = world->media[1].n;
    const int tries = 64;
    real ct;
    f->reflectance = n1 == n2 ? (real)0 : cml_fresnel(n1, n2, cml_incidence(f->start.u, against), &ct);
    for (int i = 0; i < tries && !f->enters; i++) {
        f->inside = f->start;
        f->inside.index = (cml_u64)i;
        cml_cross(world, &f->inside, hit);
        if (f->inside.shading_overruled) return;
        f->enters = f->inside.medium == 1;
    }
}

static void cml_aim(struct cml_flight *f)
{
    struct cml_packet packet = f->start;
    if (!f->pencil || packet.medium > 0 || f->world->media[0].mfp < CML_INFINITY) return;
    const struct cml_reach reach = cml_find_reach(f->world, 0, packet.p, packet.u, CML_INFINITY);
    f->aimed = cml_nearest(f->world, &packet, reach, &f->first);
    if (f->aimed && !f->to.facets) cml_find_entry(f);
}

static int cml_is_aimed(const struct cml_flight *f, int medium, cml_u32 boundary_events)
{
    return f->aimed && medium == 0 && boundary_events == 0;
}

#endif
