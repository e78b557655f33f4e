/* The start of a packet (P1): its source, place, medium and direction.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "contact.h"
#include "lattice.h"
#include "optics.h"
#include "surface_hit.h"
#include "types.h"

/* Returns the weight units that are split off packet `index` at its launch, unless boundary 0 stops it. */
CML_FN cml_u32 cml_split_off(const struct cml_world *world, cml_u64 index)
{
    return cml_source_of(world, index)->specular;
}

/* ---- place ---- */

/* Returns the last part that begins at or below `word`, 0 to count - 1. first: the word at which each part
 * begins, rising from 0. */
CML_FN int cml_word_part(const CML_GLOBAL cml_u32 *first, int count, cml_u32 word)
{
    int low = 0, high = count;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (first[middle] <= word)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Returns the place of `word` in a part of words, 0 to 1. first: word at which the part begins; next: word at
 * which the next part begins, 0 for the last part. */
CML_FN real cml_word_share(cml_u32 word, cml_u32 first, cml_u32 next)
{
    const cml_u32 count = next - first;
    return ((real)(word - first) + (real)0.5) / (count ? (real)count : (real)4294967296.0);
}

/* Returns a position in pixels: the row or column of an image, plus the place within it. words: the number of
 * rows or columns in use, then the lowest word of each. *which: its number among those in use. */
CML_FN real cml_image_place(const CML_GLOBAL cml_u32 *words, cml_u32 word, int *which)
{
    const int used = (int)words[0], k = cml_word_part(words + 1, used, word);
    *which = k;
    return (real)k + cml_word_share(word, words[1 + k], k + 1 < used ? words[2 + k] : 0u);
}

/* Returns the distance (cm) of a random place from the middle of a round shape. *c, *s: cosine and sine of
 * its azimuth. */
CML_FN real cml_round_offset(const CML_GLOBAL struct cml_source *source, struct cml_block draw, real *c,
                             real *s)
{
    const real xi = cml_uniform(draw.w[0]);
    cml_circle_point(draw.w[1], c, s);
    if (source->shape == CML_BEAM_DISK) return source->a * CML_SQRT(xi);
    if (source->shape == CML_BEAM_GAUSSIAN) return source->a * CML_SQRT((real)-0.5 * cml_log(xi));
    return CML_SQRT(CML_FMA(xi, source->b, source->a));
}

/* Finds a random place in the source's shape, along e1 and e2 from the middle, cm. */
CML_FN void cml_source_offset(const struct cml_world *world, const CML_GLOBAL struct cml_source *source,
                              struct cml_block draw, real *x, real *y)
{
    const int shape = source->shape;
    if (shape <= CML_BEAM_RING) {
        real c, s;
        const real r = cml_round_offset(source, draw, &c, &s);
        *x = r * c;
        *y = r * s;
    } else if (shape == CML_BEAM_RECTANGLE) {
        *x = source->a * cml_uniform_symmetric(draw.w[0]);
        *y = source->b * cml_uniform_symmetric(draw.w[1]);
    } else {
        const CML_GLOBAL cml_u32 *words = world->image_words + source->first_word;
        int row, column;
        const real down = cml_image_place(words, draw.w[0], &row);
        words += 1 + source->ny + row * (1 + source->nx);
        const real along = cml_image_place(words, draw.w[1], &column);
        *x = source->a * (along - (real)0.5 * (real)source->nx);
        *y = source->b * ((real)0.5 * (real)source->ny - down);
    }
}

/* ---- the medium at a place ---- */

#ifndef __OPENCL_VERSION__
/* True if p lies below a mesh, or inside a closed one. The first crossing on a path straight up decides: p is
 * below if the path comes to this crossing from below. */
CML_FN int cml_is_below_mesh(const struct cml_world *world, int boundary, struct cml_vec p)
{
    const struct cml_vec up = {0, 0, -1};
    struct cml_hit out, in;
    int near_facet;
    const int leaves = cml_intersect_mesh(world, boundary, p, up, 1, CML_INFINITY, -1, 0, &out, &near_facet);
    if (!leaves) return 0;
    return !cml_intersect_mesh(world, boundary, p, up, -1, out.t, -1, 0, &in, &near_facet);
}
#endif

/* True if p lies below a boundary between layers. p: in the boundary's frame. */
CML_FN int cml_is_below(const struct cml_world *world, int boundary, struct cml_vec p)
{
    const CML_GLOBAL struct cml_surface *surface = &world->surfaces[boundary];
    if (cml_is_plane(world, boundary)) return p.z >= 0;
    if (p.z < surface->lowest) return 0;
    if (p.z > surface->highest) return 1;
#ifndef __OPENCL_VERSION__
    if (surface->kind == CML_SURFACE_MESH) return cml_is_below_mesh(world, boundary, p);
#endif
    const struct cml_rings rings = cml_rings_of(world, boundary);
    const struct cml_vec q = cml_from_scene_axis(world, p);
    const real r = CML_SQRT(CML_FMA(q.x, q.x, q.y * q.y));
    const int ring = cml_ring_of(rings, r);
    return p.z >= CML_FMA(rings.slope[ring], r - rings.r[ring], rings.z[ring]);
}

/* True if p lies inside a body. p: in the frame of the body's layer. */
CML_FN int cml_is_inside(const struct cml_world *world, int body, struct cml_vec p)
{
    const int boundary = world->setup.num_layers + 1 + body, kind = world->surfaces[boundary].kind;
    const CML_GLOBAL struct cml_body *shape = &world->bodies[body];
#ifndef __OPENCL_VERSION__
    if (kind == CML_SURFACE_MESH) return cml_is_below_mesh(world, boundary, p);
#endif
    const struct cml_vec d = cml_along(p, -1, shape->centre);
    if (kind == CML_SURFACE_SPHERE) return cml_dot(d, d) < shape->radius * shape->radius;
    const real along = cml_dot(d, shape->axis);
    const struct cml_vec across = cml_along(d, -along, shape->axis);
    return (along > 0) & (along < shape->length) & (cml_dot(across, across) < shape->radius * shape->radius);
}

/* Returns the body in a medium that p lies in; -1 if none. */
CML_FN int cml_body_at(const struct cml_world *world, int medium, struct cml_vec p)
{
    const int end = world->media[medium].end_node;
    for (int i = world->media[medium].first_node; i < end;) {
        const CML_GLOBAL struct cml_body_node *node = &world->body_nodes[i];
        const int within = (p.x >= node->lower.x) & (p.x <= node->upper.x) & (p.y >= node->lower.y) &
                           (p.y <= node->upper.y) & (p.z >= node->lower.z) & (p.z <= node->upper.z);
        if (within && node->body >= 0 && cml_is_inside(world, node->body, p)) return node->body;
        i = within ? i + 1 : node->skip;
    }
    return -1;
}

/* Returns the medium at *p. On entry *p is in the frame of `medium`, a layer or outer medium; on return it is
 * in the frame of the medium that was found. */
CML_FN int cml_medium_at(const struct cml_world *world, int medium, struct cml_vec *p)
{
    const int layers = world->setup.num_layers;
    while (medium > 0 && !cml_is_below(world, medium - 1, *p)) p->z += world->media[--medium].span;
    for (; medium <= layers; medium++) {
        struct cml_vec below = *p;
        below.z -= world->media[medium].span;
        if (!cml_is_below(world, medium, below)) break;
        *p = below;
    }
    if (!CML_MAY_HAVE_BODIES || !world->setup.num_bodies) return medium;
    for (int body = cml_body_at(world, medium, *p); body >= 0; body = cml_body_at(world, medium, *p))
        medium = layers + 2 + body;
    return medium;
}

/* ---- direction ---- */

/* Returns 1 - cosine of a direction drawn from a table. Within a part of the table, the density is linear in
 * the cosine. */
CML_FN real cml_table_polar(const struct cml_world *world, const CML_GLOBAL struct cml_source *source,
                            cml_u32 word)
{
    const CML_GLOBAL struct cml_light_cell *cells = world->light_cells + source->first_cell;
    int low = 0, high = source->num_cells;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (cells[middle].first <= word)
            low = middle;
        else
            high = middle;
    }
    const struct cml_light_cell cell = cells[low];
    const real xi = cml_word_share(word, cell.first, low + 1 < source->num_cells ? cells[low + 1].first : 0u);
    const real square =
        CML_FMA(xi, (cell.end - cell.begin) * (cell.end + cell.begin), cell.begin * cell.begin);
    return CML_FMA(cell.width, xi * (cell.begin + cell.end) / (cell.begin + CML_SQRT(square)), cell.v);
}

/* Returns a direction made of e1, e2 and the axis, drawn with words 2 and 3 of the packet's launch. n:
 * refractive index of the medium at the start. */
CML_FN struct cml_vec cml_source_turn(const struct cml_world *world,
                                      const CML_GLOBAL struct cml_source *source, struct cml_block draw,
                                      real n)
{
    real v, c, s, cosine, sine;
    if (source->light == CML_LIGHT_COSINE) {
        const real square = cml_uniform(draw.w[2]); /* never 0: no packet flies level */
        cosine = CML_SQRT(square);
        sine = CML_SQRT(1 - square);
    } else {
        const real aperture = source->aperture < n ? source->aperture / n : (real)1,
                   square = aperture * aperture;
        const real widest = source->spread > 0 ? source->spread : square / (1 + CML_SQRT(1 - square));
        v = source->light == CML_LIGHT_TABLE ? cml_table_polar(world, source, draw.w[2])
                                             : widest * cml_uniform(draw.w[2]);
        cosine = 1 - v;
        sine = CML_SQRT(v * (2 - v));
    }
    cml_circle_point(draw.w[3], &c, &s);
    const struct cml_vec turn = {sine * c, sine * s, cosine};
    return turn;
}

/* Returns the launch direction in the coordinates of the scene: cml_source_turn about the axis of the
 * source. */
CML_FN struct cml_vec cml_source_direction(const struct cml_world *world,
                                           const CML_GLOBAL struct cml_source *source, struct cml_block draw,
                                           real n)
{
    const struct cml_vec none = {0, 0, 0}, turn = cml_source_turn(world, source, draw, n);
    const struct cml_vec across = cml_along(cml_along(none, turn.x, source->e1), turn.y, source->e2);
    return cml_normalise(cml_along(across, turn.z, source->axis));
}

/* ---- launch ---- */

/* Sets the optical path that a packet has behind it (P11). A device keeps no time. */
CML_FN void cml_set_path(CML_PACKET struct cml_packet *packet, real path)
{
#ifdef __OPENCL_VERSION__
    (void)packet, (void)path;
#else
    packet->path = path;
#endif
}

/* Returns the optical path (cm) from boundary 0 into a medium for a packet that has come straight through
 * planes (P11). */
CML_FN real cml_path_above(const struct cml_world *world, int medium)
{
    return medium > 1 ? world->media[1].n * world->media[1].span : (real)0;
}

/* Starts a packet of a source inside at its place in the shape, and finds its medium there. */
CML_FN void cml_place_inside(const struct cml_world *world, const CML_GLOBAL struct cml_source *source,
                             struct cml_vec at, CML_PACKET struct cml_packet *packet)
{
    int medium = source->medium;
    if (!source->is_pencil) medium = cml_medium_at(world, medium, &at);
    packet->p = at;
    packet->medium = medium;
    packet->entered = medium > 0;
    cml_set_path(packet, 0);
    packet->exit_x = at.x;
    packet->exit_y = at.y;
}

/* Starts a packet above all surfaces, on its line through `at`, its place in the shape. A packet that would
 * start below boundary 0 starts above it, with its whole weight, where faces or ports stop it. */
CML_FN void cml_place_above(const struct cml_world *world, const CML_GLOBAL struct cml_source *source,
                            struct cml_vec at, CML_PACKET struct cml_packet *packet)
{
    packet->p = cml_along(at, (source->start - at.z) / packet->u.z, packet->u);
    packet->p.z = source->start;
#ifndef __OPENCL_VERSION__
    if (!world->contacts.count || packet->medium == 0 || source->port) return;
    const struct cml_contact *contact = cml_contact_of(world, cml_contact_at(world, at.x, at.y));
    if (!contact || !contact->stops) return;
    packet->medium = packet->entered = 0;
    packet->w = CML_WEIGHT_ONE;
    packet->path = -1;
#else
    (void)world;
#endif
}

/* Starts a packet of a source far outside of the scene: moves it along its line onto the level `start` (P1).
 *
 *         source, far away             x, y: place in the source's shape
 *             \      .                 turn: direction along e1, e2 and the axis
 *              \    '
 *      ---------*--'---------------    level `start`, near the scene; the packet starts here
 *
 * A direction within CML_NEARLY_LEVEL of square to the axis meets the level further off than anything is. The
 * distance from the source counts as flown. */
#define CML_NEARLY_LEVEL ((real)9.5367431640625e-7)
CML_FN void cml_place_far(const struct cml_world *world, const CML_GLOBAL struct cml_source *source, real x,
                          real y, struct cml_vec turn, CML_PACKET struct cml_packet *packet)
{
    const real cosine = turn.z < CML_NEARLY_LEVEL && turn.z > -CML_NEARLY_LEVEL ? CML_NEARLY_LEVEL : turn.z;
    const real way = source->ahead / cosine, uz = packet->u.z;
    const struct cml_vec at = cml_along(cml_along(source->middle, CML_FMA(way, turn.x, x), source->e1),
                                        CML_FMA(way, turn.y, y), source->e2);
    const real rest = uz < CML_NEARLY_LEVEL && uz > -CML_NEARLY_LEVEL ? (real)0 : (source->start - at.z) / uz;
    packet->p = cml_along(at, rest, packet->u);
    packet->p.z = source->start;
    packet->exit_x = packet->p.x;
    packet->exit_y = packet->p.y;
    cml_set_path(packet, way + rest > 0 ? world->media[source->medium].n * (way + rest) : (real)0);
}

/* Returns the place in a port at x, y from its middle: a port is level, however its light is inclined. */
CML_FN struct cml_vec cml_in_port(const CML_GLOBAL struct cml_source *source, real x, real y)
{
    const struct cml_vec at = {source->middle.x + x, source->middle.y + y, 0};
    return at;
}

/* Places a packet of a source of any shape and light, and gives the packet its direction. */
CML_RARE void cml_place_any(const struct cml_world *world, const CML_GLOBAL struct cml_source *source,
                            CML_PACKET struct cml_packet *packet)
{
    const int spread = source->light != CML_LIGHT_PARALLEL;
    const struct cml_block draw = cml_draw_launch(world->setup.stream, packet->index, spread);
    struct cml_vec at = source->middle;
    real x = 0, y = 0;
    if (source->shape != CML_BEAM_PENCIL) {
        cml_source_offset(world, source, draw, &x, &y);
        at = cml_along(cml_along(at, x, source->e1), y, source->e2);
        if (source->port) at = cml_in_port(source, x, y);
    }
    if (source->inside && !source->is_far) cml_place_inside(world, source, at, packet);
    const real n = world->media[packet->medium].n;
    if (spread) packet->u = cml_source_direction(world, source, draw, n);
    if (!source->inside) cml_place_above(world, source, at, packet);
    if (!source->is_far) return;
    const struct cml_vec straight = {0, 0, 1};
    cml_place_far(world, source, x, y, spread ? cml_source_turn(world, source, draw, n) : straight, packet);
}

/* Places packet `index` where its beam puts it (P1); its optical depth is not drawn yet. Pencils, disks and
 * Gaussians of parallel light from above are most common, so they have a short way of their own. */
CML_FN void cml_place(const struct cml_world *world, cml_u64 index, CML_PACKET struct cml_packet *packet)
{
    const CML_GLOBAL struct cml_source *source = cml_source_of(world, index);
    const struct cml_packet fresh = {0};
    struct cml_vec at = source->middle;
    *packet = fresh;
    packet->index = index;
    packet->w = CML_WEIGHT_ONE - source->specular;
    packet->medium = source->medium;
    packet->entered = source->medium > 0;
    packet->on_boundary = -1;
    packet->on_primitive = -1;
    packet->u = source->axis;
    cml_set_path(packet, source->medium > 0 ? cml_path_above(world, source->medium) : (real)-1);
    if (!source->is_common) {
        cml_place_any(world, source, packet);
        return;
    }
    if (source->shape != CML_BEAM_PENCIL) {
        real c, s;
        const struct cml_block draw = cml_draw_launch(world->setup.stream, index, 0);
        const real r = cml_round_offset(source, draw, &c, &s);
        at = cml_along(cml_along(at, r * c, source->e1), r * s, source->e2);
    }
    cml_place_above(world, source, at, packet);
}

/* Returns the weight units that were split off a packet at its launch: none if boundary 0 has stopped it. */
CML_FN cml_u32 cml_has_split_off(const struct cml_world *world, CML_PACKET const struct cml_packet *packet)
{
#ifndef __OPENCL_VERSION__
    if (packet->face == CML_WEIGHT_ONE) return 0;
#endif
    return cml_split_off(world, packet->index);
}

/* True if the weight of one packet balances (P10): its weight at the start and later gains are all accounted
 * for. */
CML_FN int cml_packet_balances(const struct cml_world *world, CML_PACKET const struct cml_packet *packet)
{
    cml_u64 out =
        cml_has_split_off(world, packet) + packet->absorbed + packet->backing + packet->roulette + packet->w;
#ifndef __OPENCL_VERSION__
    out += packet->face;
#endif
    return CML_WEIGHT_ONE + packet->gained == out;
}
