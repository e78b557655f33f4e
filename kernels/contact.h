/* Surfaces and media that touch the material from outside: the backing under the last layer, faces and ports
 * on boundary 0 (P12).
 *
 *      n above     face          port: a medium of index N
 *     ........  ==========  |        |
 *     ---------------------------------------- boundary 0
 *      layer 1
 *
 * cml_meeting_at is the one place where a packet asks what it meets. No device has faces or ports.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "optics.h"
#include "surface_hit.h"
#include "types.h"

#ifndef __OPENCL_VERSION__
#include "detector.h"

/* Returns the number of the contact that lies on top at x, y of boundary 0 (cm from the scene's origin); 0:
 * the open plane. */
CML_FN int cml_contact_at(const struct cml_world *world, real x, real y)
{
    const struct cml_contacts *contacts = &world->contacts;
    const int cell = cml_detector_cell(&contacts->grid, x, y);
    for (int i = cell < 0 ? 0 : contacts->start[cell + 1]; i > 0 && i-- > contacts->start[cell];) {
        const int k = contacts->list[i];
        if (cml_is_in_area(&contacts->item[k].area, x, y)) return k + 1;
    }
    return contacts->whole;
}

/* Returns the contact with this number, NULL for 0. */
CML_FN const struct cml_contact *cml_contact_of(const struct cml_world *world, int number)
{
    return number ? &world->contacts.item[number - 1] : NULL;
}

#endif

/* Returns the source of packet `index`. With several sources, the index holds the number of the source above
 * the 48 bits of the packet's number. */
CML_FN const CML_GLOBAL struct cml_source *cml_source_of(const struct cml_world *world, cml_u64 index)
{
    return world->sources + (world->setup.num_sources > 1 ? (int)(index >> CML_SOURCE_SHIFT) : 0);
}

/* The other side of a boundary, as a packet meets it. */
struct cml_meeting {
    const struct cml_backing *opaque; /* surface that turns the packet back; NULL: a medium */
    real n_above;                     /* index of the medium above the boundary, at this place */
    int stops;                        /* 1: the packet comes from above and ends here */
};

/* Returns the backing at a boundary; NULL if there is none, and light refracts there. */
CML_FN const struct cml_backing *cml_backing_at(const struct cml_world *world, int boundary)
{
    return boundary == world->setup.backing.boundary ? &world->setup.backing : NULL;
}

/* True if something touches a boundary from outside, so that packets may not just be reflected or refracted.
 */
CML_FN int cml_is_touched(const struct cml_world *world, int boundary)
{
    int touched = boundary == world->setup.backing.boundary;
#ifndef __OPENCL_VERSION__
    touched |= (boundary == 0) & (world->contacts.count > 0);
#endif
    return touched;
}

/* Returns what a packet meets at a hit. below: 1 if it comes from below. Light that starts in a port meets
 * boundary 0 there, even if rounding has put it beyond the rim. */
CML_FN struct cml_meeting cml_meeting_at(const struct cml_world *world,
                                         CML_PACKET const struct cml_packet *packet,
                                         const struct cml_hit *hit, int below)
{
    const int above = below ? world->surfaces[hit->boundary].above : packet->medium;
    struct cml_meeting meeting = {cml_backing_at(world, hit->boundary), world->media[above].n, 0};
#ifndef __OPENCL_VERSION__
    if (hit->boundary == 0 && world->contacts.count) {
        const int own = below ? 0 : cml_source_of(world, packet->index)->port;
        const struct cml_contact *contact =
            cml_contact_of(world, own ? own : cml_contact_at(world, hit->point.x, hit->point.y));
        if (contact && contact->is_port) meeting.n_above = (real)contact->n;
        if (contact && !contact->is_port && below) meeting.opaque = &contact->face;
        meeting.stops = contact && !below && !own && contact->stops;
    }
#endif
    return meeting;
}

/* Ends a packet that comes from above where nothing passes. */
CML_FN void cml_stop(CML_PACKET struct cml_packet *packet)
{
#ifndef __OPENCL_VERSION__
    packet->face += packet->w;
#endif
    packet->w = 0;
    cml_end_packet(packet, CML_FATE_ABSORBED);
}

/* Returns the direction of light that a backing sends back (P12). against: unit normal against u. */
CML_FN struct cml_vec cml_backing_direction(struct cml_backing backing, struct cml_vec u,
                                            struct cml_vec against, struct cml_block draw)
{
    real c, s;
    if (backing.kind != CML_BACKING_LAMBERTIAN) return cml_reflect(u, against);
    const real square = cml_uniform(draw.w[1]); /* never 0: no packet flies level */
    cml_circle_point(draw.w[2], &c, &s);
    return cml_deflect(against, (real)1 / cml_frame_divisor(against), CML_SQRT(square), CML_SQRT(1 - square),
                       c, s);
}

/* Leaves the share `kept` of a packet's weight in the opaque surface at a boundary (P12), rounded as in P3.
 */
CML_FN void cml_keep(CML_PACKET struct cml_packet *packet, int boundary, real kept, struct cml_block draw)
{
    const cml_u32 dw = cml_absorbed_part(packet->w, kept, draw.w[0], draw.w[3]);
#ifndef __OPENCL_VERSION__
    if (boundary == 0)
        packet->face += dw;
    else
#endif
        packet->backing += dw;
    packet->w -= dw;
    if (packet->w == 0) cml_end_packet(packet, CML_FATE_ABSORBED);
}

/* Turns a packet back at a smooth opaque surface, which keeps a part of its weight (P12): a backing, seen
 * from above, or a face, seen from below. The facet overrules the shading normal, as in
 * cml_reflect_or_refract. */
CML_FN void cml_turn_back(const struct cml_world *world, const struct cml_backing *shared,
                          CML_PACKET struct cml_packet *packet, const struct cml_hit *hit)
{
    const struct cml_backing backing = *shared;
    const struct cml_vec from = packet->u, down = {0, 0, 1};
    const struct cml_vec facet = hit->boundary == 0 ? down : hit->facet;
    const struct cml_block draw =
        cml_draw(world->setup.stream, packet->index, CML_PURPOSE_BACKING, packet->crossings);
    const int shaded = hit->normal.x != hit->facet.x || hit->normal.y != hit->facet.y;
    struct cml_vec normal = hit->boundary == 0 ? down : hit->normal;
    packet->crossings++;
    if (cml_dot(from, facet) > 0) return;
    packet->u = cml_backing_direction(backing, from, normal, draw);
    if (cml_dot(packet->u, facet) < (shaded ? CML_SHADED_LEAST : (real)0) ||
        (shaded && packet->bounces >= CML_SHADED_LIMIT)) {
        normal = facet;
        packet->u = cml_backing_direction(backing, from, normal, draw);
        packet->shading_overruled++;
    }
    const real kept = backing.kind == CML_BACKING_METAL
                          ? 1 - cml_metal_reflectance(backing.n, backing.k, cml_incidence(from, normal))
                          : backing.kept;
    cml_keep(packet, hit->boundary, kept, draw);
}
