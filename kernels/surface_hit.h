/* The next crossing of a packet with the boundaries of its medium, of any kind.
 * A packet crosses a boundary only away from its own side: upwards if it is below, downwards if it is above.
 * This rule, not a small distance, keeps a packet from meeting again the surface that it has just left.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "body.h"
#include "bounds.h"
#include "cone.h"
#include "optics.h"
#include "types.h"

/* Returns the rings of a boundary that is a radial heightfield. */
CML_FN struct cml_rings cml_rings_of(const struct cml_world *world, int boundary)
{
    const CML_GLOBAL struct cml_surface *surface = &world->surfaces[boundary];
    const int first = surface->first_ring;
    const struct cml_rings rings = {world->ring_r + first,     world->ring_z + first,
                                    world->ring_slope + first, world->ring_start + first,
                                    surface->parts_per_cm,     surface->num_rings};
    return rings;
}

/* Returns the error by rounding in the depths of a path that begins at z and rises or falls by `step`; all in
 * cm. */
CML_FN real cml_err_depth(real z, real step)
{
    return 4 * CML_EPSILON * (CML_FABS(z) + CML_FABS(step));
}

/* Finds the crossing with the plane z = 0 of its frame. side: +1 the packet is below, -1 above. A packet that
 * rounding has put beyond the plane crosses at once if it heads outwards. */
CML_FN int cml_intersect_plane(struct cml_vec p, struct cml_vec u, real side, real t_max, struct cml_hit *hit)
{
    if (!(side * u.z < 0)) return 0;
    const real t = -p.z / u.z;
    if (!(t < t_max)) return 0;
    const struct cml_vec up = {0, 0, -1};
    hit->t = t > 0 ? t : (real)0;
    hit->point = cml_along(p, hit->t, u);
    hit->point.z = 0;
    hit->normal = up;
    hit->facet = up;
    hit->primitive = 0;
    return 1;
}

/* Finds the crossing with a radial heightfield on the interval `s` of a path. p: in the boundary's frame.
 * first: 1 if the packet has met no boundary yet. Such a beam may well be aimed at a ridge, where the mean
 * normal holds (P1). A later packet meets a ridge only because rounding put it there, and the normal of the
 * ring that it meets is the better one. */
CML_FN int cml_intersect_field(const struct cml_world *world, int boundary, struct cml_vec p,
                               struct cml_vec u, real side, struct cml_interval s, int on_primitive,
                               int first, struct cml_hit *hit)
{
    const struct cml_rings rings = cml_rings_of(world, boundary);
    const real t_min = on_primitive >= 0 ? (real)0 : s.from;
    real t;
    int ring;
    if (!cml_cone_hit(rings, cml_from_scene_axis(world, p), u, side, t_min, s.to, on_primitive, &t, &ring))
        return 0;
    hit->t = t;
    hit->point = cml_along(p, t, u);
    hit->point.z = cml_clamp_to_ring(rings.z[ring], cml_ring_end(rings, ring), hit->point.z);
    const struct cml_vec q = cml_from_scene_axis(world, hit->point);
    /* At the tip a packet meets the side to which it goes. A level facet there would turn some packets to the
     * tip for ever. */
    const int at_tip = !first & (q.x == 0) & (q.y == 0);
    hit->facet = cml_cone_facet(rings, ring, at_tip ? u.x : q.x, at_tip ? u.y : q.y);
    hit->normal = first ? cml_cone_normal(rings, ring, q.x, q.y) : hit->facet;
    hit->primitive = ring;
    return 1;
}

#ifndef __OPENCL_VERSION__
/* Returns the distance (cm) by which rounding may have moved a packet at x, y, z in a boundary's frame. span:
 * thickness of the layer in whose frame z was rounded. */
CML_FN double cml_err_position(double x, double y, double z, double span)
{
    return 4 * (double)CML_EPSILON * (fabs(x) + fabs(y) + fabs(z) + span);
}

/* True if a path is the one whose answer is known (struct cml_known_path). */
CML_FN int cml_is_known_path(const struct cml_known_path *known, int boundary, struct cml_vec p,
                             struct cml_vec u, real t_max, int on_primitive)
{
    return p.x == known->p.x && p.y == known->p.y && p.z == known->p.z && u.x == known->u.x &&
           u.y == known->u.y && u.z == known->u.z && boundary == 0 && on_primitive == known->on_primitive &&
           t_max > known->least && (t_max < known->most || t_max > known->from);
}

/* Asks a mesh for the first crossing of a path (struct cml_mesh_crossing). *near_facet: the crossing's
 * ends_near_facet. */
CML_FN int cml_intersect_mesh(const struct cml_world *world, int boundary, struct cml_vec p, struct cml_vec u,
                              real side, real t_max, int on_primitive, int undeflected, struct cml_hit *hit,
                              int *near_facet)
{
    const struct cml_known_path *known = world->known_path;
    if (known && cml_is_known_path(known, boundary, p, u, t_max, on_primitive)) {
        *near_facet = 0;
        if (t_max > known->from) *hit = known->hit;
        return t_max > known->from;
    }
    const double dp[3] = {p.x, p.y, p.z}, du[3] = {u.x, u.y, u.z};
    /* p.z was rounded in the frame of the layer above. */
    const double span = side < 0 ? (double)world->media[boundary].span : 0;
    const double err_position = cml_err_position(dp[0], dp[1], dp[2], span);
    struct cml_mesh_crossing c;
    const int found = world->intersect_mesh(world->meshes[boundary], dp, du, side > 0, t_max, on_primitive,
                                            undeflected, sizeof(real) == sizeof(double), err_position, &c);
    *near_facet = c.ends_near_facet;
    if (!found) return 0;
    hit->t = (real)c.t;
    hit->primitive = c.primitive;
    const struct cml_vec point = {(real)c.point[0], (real)c.point[1], (real)c.point[2]};
    const struct cml_vec normal = {(real)c.normal[0], (real)c.normal[1], (real)c.normal[2]};
    const struct cml_vec facet = {(real)c.facet[0], (real)c.facet[1], (real)c.facet[2]};
    hit->point = point;
    hit->normal = normal;
    hit->facet = facet;
    return 1;
}
#endif

CML_FN void cml_end_packet(CML_PACKET struct cml_packet *packet, enum cml_fate fate)
{
    packet->fate = (int)fate;
}

/* Ends a packet as lost (P9). */
CML_FN void cml_lose_packet(CML_PACKET struct cml_packet *packet, enum cml_lost_cause cause)
{
    packet->fate = CML_FATE_LOST;
    packet->cause = (int)cause;
}

/* Finds the packet's crossing with one boundary of its layer on the interval `s`. p: the packet in that
 * boundary's frame. Returns 0, and leaves *hit as it is, if there is none. */
CML_FN int cml_intersect_surface(const struct cml_world *world, CML_PACKET struct cml_packet *packet,
                                 int boundary, struct cml_vec p, real side, struct cml_interval s,
                                 struct cml_hit *hit)
{
    const CML_GLOBAL struct cml_surface *surface = &world->surfaces[boundary];
    const int on_primitive = cml_on_primitive(packet, boundary);
    int found = 0;
    if (CML_ALL_PLANES || surface->kind == CML_SURFACE_PLANE) {
        found = cml_intersect_plane(p, packet->u, side, s.to, hit);
    } else {
        packet->queries++;
        if (surface->kind == CML_SURFACE_CONE)
            found = cml_intersect_field(world, boundary, p, packet->u, side, s, on_primitive,
                                        packet->boundary_events == 0, hit);
#ifndef __OPENCL_VERSION__
        else {
            int near_facet;
            found = cml_intersect_mesh(world, boundary, p, packet->u, side, s.to, on_primitive,
                                       packet->undeflected, hit, &near_facet);
            if (near_facet == CML_PATH_TOO_LONG)
                cml_lose_packet(packet, CML_LOST_TOO_FAR);
            else if (near_facet)
                packet->near_boundary = boundary + 1;
        }
#endif
    }
    if (found) hit->boundary = boundary;
    return found;
}

/* Returns the packet's place from the centre of a sphere or the first end of a cylinder. For a packet that
 * stands on a sphere `off` is more exact than p, and so is any place found from it. */
CML_FN struct cml_vec cml_from_body(const struct cml_world *world, CML_PACKET const struct cml_packet *packet,
                                    const CML_GLOBAL struct cml_body *body)
{
    const int on = packet->on_boundary, first = world->setup.num_layers + 1;
    if (on < first || packet->on_primitive < 0 || world->surfaces[on].kind != CML_SURFACE_SPHERE)
        return cml_along(packet->p, -1, body->centre);
    return cml_along(cml_along(world->bodies[on - first].centre, -1, body->centre), 1, packet->off);
}

/* Finds the packet's crossing with the surface of a body before t_max. side: +1 from inside, -1 from outside;
 * afar: 1 if the packet is away from all bodies. Returns 0, and leaves *hit as it is, if there is none. */
CML_FN int cml_intersect_body(const struct cml_world *world, CML_PACKET struct cml_packet *packet,
                              int boundary, real side, real t_max, int afar, struct cml_hit *hit)
{
    const CML_GLOBAL struct cml_body *body = &world->bodies[boundary - world->setup.num_layers - 1];
    const int kind = world->surfaces[boundary].kind, on_primitive = cml_on_primitive(packet, boundary);
    const struct cml_vec u = packet->u;
    struct cml_body_hit at = {0};
    int found = 1;
    packet->queries++;
#ifndef __OPENCL_VERSION__
    if (kind == CML_SURFACE_MESH) {
        int near_facet;
        const int on = afar && on_primitive == -1 ? CML_OFF_FACETS : on_primitive;
        found = cml_intersect_mesh(world, boundary, packet->p, u, side, t_max, on, packet->undeflected, hit,
                                   &near_facet);
        if (near_facet) packet->near_boundary = boundary + 1;
        if (found) hit->boundary = boundary;
        if (found) hit->off = at.off;
        return found;
    }
#endif
    (void)afar;
    /* A packet that stands on a convex body and is outside never meets it again. */
    if (side < 0 && on_primitive >= 0) return 0;
    const struct cml_vec d = cml_from_body(world, packet, body);
    if (kind == CML_SURFACE_SPHERE) {
        if (side > 0)
            cml_leave_sphere(d, u, body->radius, on_primitive >= 0, &at);
        else
            found = cml_enter_sphere(d, u, body->radius, &at);
    } else {
        const struct cml_cylinder_line line =
            cml_cylinder_line_of(body, d, u, on_primitive, packet->off, side > 0);
        if (side > 0)
            cml_leave_cylinder(&line, &at);
        else
            found = cml_enter_cylinder(&line, &at);
    }
    if (!found || !(at.t < t_max)) return 0;
    cml_place_on_body(body, &at, hit);
    hit->boundary = boundary;
    return 1;
}

/* Finds the packet's first crossing with the surface of a body before t_max. A packet inside a body may
 * meet the surface of this body, and every packet those of the bodies that lie in its medium. */
CML_FN int cml_nearest_body(const struct cml_world *world, CML_PACKET struct cml_packet *packet, real t_max,
                            int afar, struct cml_hit *hit)
{
    const int layers = world->setup.num_layers, own = cml_is_body(world, packet->medium);
    const CML_GLOBAL struct cml_medium *medium = &world->media[packet->medium];
    const struct cml_vec per_u = {1 / packet->u.x, 1 / packet->u.y, 1 / packet->u.z};
    int found = own && cml_intersect_body(world, packet, packet->medium - 1, 1, t_max, afar, hit);
    for (int i = medium->first_node; i < medium->end_node;) {
        const CML_GLOBAL struct cml_body_node *node = &world->body_nodes[i];
        const int passes = cml_passes_box(node, packet->p, per_u, found ? hit->t : t_max);
        if (passes && node->body >= 0)
            found |= cml_intersect_body(world, packet, layers + 1 + node->body, -1, found ? hit->t : t_max,
                                        afar, hit);
        i = passes ? i + 1 : node->skip;
    }
    return found;
}

/* Finds the packet's first crossing with a boundary of its medium. intervals: the parts of the path to
 * search. A packet that is lost in the search (P9) has ended. */
CML_FN int cml_nearest_hit(const struct cml_world *world, CML_PACKET struct cml_packet *packet,
                           struct cml_boundary_intervals intervals, struct cml_hit *hit)
{
    const int medium = packet->medium;
    int found = 0;
    packet->near_boundary = 0;
    if (intervals.above.meets) {
        found = cml_intersect_surface(world, packet, medium - 1, packet->p, 1, intervals.above, hit);
        if (found && hit->t < intervals.below.to) intervals.below.to = hit->t;
    }
    if (intervals.below.meets) {
        struct cml_vec p = packet->p;
        p.z -= world->media[medium].span;
        found |= cml_intersect_surface(world, packet, medium, p, -1, intervals.below, hit);
    }
    if (intervals.bodies)
        found |= cml_nearest_body(world, packet, found ? hit->t : intervals.reach,
                                  intervals.bodies == CML_BODIES_FROM_AFAR, hit);
    return found;
}

/* ---- invariants of every packet, for CML_ASSERT: release builds and devices never call these ---- */

/* True if |u|^2 is 1 within the rounding of one event. unit.optics finds at most 1e-6, 9 spacings of single
 * precision, over a million events. A direction that is not a number passes, because P9 ends such packets. */
CML_FN int cml_is_unit(struct cml_vec u)
{
    return !(CML_FABS(cml_dot(u, u) - 1) > 16 * CML_EPSILON);
}

/* True if p lies on the given side of a boundary (+1 below it, -1 above), as far as the depth bounds of p's
 * cell tell (bounds.h). p: in the boundary's frame. err: error of its depth by rounding, cm; for a curved
 * boundary the margin of cml_leaked is added. */
CML_FN int cml_is_on_side(const struct cml_world *world, int boundary, struct cml_vec p, real side, real err)
{
    const CML_GLOBAL struct cml_surface *surface = &world->surfaces[boundary];
    const CML_GLOBAL struct cml_depth_bounds *map = &surface->depths;
    const CML_GLOBAL real *bounds = (side > 0 ? world->highest : world->deepest) + map->first;
    if (cml_is_plane(world, boundary)) return !(side * p.z < -err);
    if (map->size == 0) return 1;
    const real margin = (surface->highest - surface->lowest) * (real)0.0009765625 + err;
    const struct cml_vec q = cml_from_scene_axis(world, p);
    const struct cml_vec still = {0, 0, 0};
    if (map->form == CML_BOUNDS_PERIOD)
        return !(side * p.z < -cml_depth_over_period(map, bounds - map->first, q, still, -side) - margin);
    int cell = cml_depth_cell(map, CML_SQRT(q.x * q.x + q.y * q.y), 0);
    if (surface->kind != CML_SURFACE_CONE)
        cell = cml_depth_cell(map, q.y, map->corner_y) * map->size + cml_depth_cell(map, q.x, map->corner_x);
    return !(side * p.z < side * bounds[cell] - margin);
}

/* True if a packet that has come to p on a path of height `step` is still in its medium. p: in the frame of
 * the medium. */
CML_FN int cml_is_in_layer(const struct cml_world *world, int medium, struct cml_vec p, real step)
{
    const real span = world->media[medium].span, err = cml_err_depth(p.z, step) + cml_err_depth(span, span);
    struct cml_vec below = p;
    if (medium > world->setup.num_layers + 1) return 1; /* bodies: cml_leaked has checked them */
    below.z -= span;
    return medium > 0 && medium <= world->setup.num_layers && cml_is_on_side(world, medium - 1, p, 1, err) &&
           cml_is_on_side(world, medium, below, -1, err);
}
