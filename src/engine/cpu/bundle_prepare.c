/* SPDX-License-Identifier: MIT */
#include "engine/cpu/bundle_prepare.h"

#include "surface/mesh/mesh_surface.h"

/* A plane needs no start depth: only a path that ends beyond a plane meets it (cml_find_lane_candidates). A
 * plane with a backing, faces or ports counts as curved, because lanes go by kernels/walk.h there. A medium
 * without a boundary on one side, an outer one or a body's, has infinite depths and its own index there. */
struct cml_lane_medium cml_lane_medium_of(const struct cml_world *world, int m)
{
    const struct cml_medium *medium = &world->media[m];
    const int layers = world->setup.num_layers, in_body = m > layers + 1;
    const struct cml_surface *top = m > 0 && !in_body ? &world->surfaces[m - 1] : NULL;
    const struct cml_surface *bottom = m <= layers ? &world->surfaces[m] : NULL;
    const int plane_top = top && top->kind == CML_SURFACE_PLANE && !cml_is_touched(world, m - 1);
    const int plane_bottom = bottom && bottom->kind == CML_SURFACE_PLANE && !cml_is_touched(world, m);
    const real stop_above = top ? top->highest : -CML_INFINITY;
    const real stop_below = bottom ? medium->span + bottom->lowest : CML_INFINITY;
    const struct cml_lane_medium lane = {
        .mut = medium->mut,
        .mfp = medium->mfp,
        .absorb = medium->absorb,
        .g = medium->g,
        .bins = medium->bins,
        .n = medium->n,
        .n_above = top ? medium[-1].n : medium->n,
        .n_below = bottom ? medium[1].n : medium->n,
        .span = medium->span,
        .stop_above = stop_above,
        .stop_below = stop_below,
        .start_above = plane_top ? -CML_INFINITY : stop_above,
        .start_below = plane_bottom ? CML_INFINITY : stop_below,
    };
    return lane;
}

/* Finds the state of packets like `like` after they are transmitted at a boundary. It is the same for all
 * packets, except for the random number that decides on transmission, so some photon indices are tried until
 * one gets through. Returns 0 if none does, or if shading normals make the outcome depend on more than
 * that. */
static int cml_transmit_like(const struct cml_world *world, const struct cml_packet *like,
                             const struct cml_hit *hit, struct cml_packet *through)
{
    const int tries = 64;
    for (int i = 0; i < tries; i++) {
        *through = *like;
        through->index = (cml_u64)i;
        cml_boundary_event(world, through, hit);
        if (through->shading_overruled) return 0;
        if (through->medium != like->medium) return 1;
    }
    return 0;
}

/* Returns Fresnel's reflectance of a packet at a hit (P5); 0 between equal indices. */
static real cml_reflectance_at(const struct cml_world *world, const struct cml_packet *packet,
                               const struct cml_hit *hit)
{
    const int below = packet->medium == hit->boundary + 1;
    const int other = below ? world->surfaces[hit->boundary].above : hit->boundary + 1;
    const real n1 = world->media[packet->medium].n, n2 = world->media[other].n;
    const real side = below ? (real)1 : (real)-1;
    const struct cml_vec up = hit->normal, against = {-side * up.x, -side * up.y, -side * up.z};
    real ct;
    return n1 == n2 ? (real)0 : cml_fresnel(n1, n2, cml_incidence(packet->u, against), &ct);
}

/* The hit is not known if the medium above scatters or absorbs: packets then have no common path. */
void cml_find_first_hit(struct cml_flight *f)
{
    struct cml_packet packet = f->start;
    if (!f->pencil || packet.medium > 0 || f->world->media[0].mfp < CML_INFINITY ||
        cml_is_touched(f->world, 0))
        return;
    const struct cml_boundary_intervals intervals = cml_find_intervals(f->world, &packet, CML_INFINITY);
    f->first_hit_known = cml_nearest_hit(f->world, &packet, intervals, &f->first_hit);
    if (!f->first_hit_known || f->to.facets || f->to.phi || f->world->surfaces[0].rough.kind) return;
    f->reflectance = cml_reflectance_at(f->world, &f->start, &f->first_hit);
    f->enters = cml_transmit_like(f->world, &f->start, &f->first_hit, &f->inside);
}

/* If paths, visits or expected values are counted, lanes cross the plane by themselves. */
void cml_find_entry(struct cml_flight *f)
{
    const struct cml_world *world = f->world;
    const struct cml_setup *setup = &world->setup;
    struct cml_packet packet = f->start;
    struct cml_hit hit;
    if (!f->queue_places || packet.medium > 0 || world->media[0].mfp < CML_INFINITY ||
        !cml_is_plane(world, 0) || world->surfaces[0].rough.kind || cml_is_touched(world, 0) ||
        setup->keeps_paths || f->tally->stay || f->to.expected)
        return;
    const struct cml_boundary_intervals intervals = cml_find_intervals(world, &packet, CML_INFINITY);
    f->enters = cml_nearest_hit(world, &packet, intervals, &hit) &&
                cml_transmit_like(world, &packet, &hit, &f->inside);
}

/* All packets of a pencil beam begin alike below the mesh, so most of them then need no search. */
void cml_find_known_path(struct cml_flight *f)
{
    const struct cml_world *world = f->world;
    const struct cml_packet *in = &f->inside;
    const struct cml_vec p = in->p, u = in->u;
    const double dp[3] = {p.x, p.y, p.z}, du[3] = {u.x, u.y, u.z}, err = cml_err_position(p.x, p.y, p.z, 0);
    const int on = in->on_primitive, undeflected = in->undeflected;
    struct cml_mesh_stretch s;
    int near_facet;
    if (!f->enters || in->medium != 1 || world->surfaces[0].kind != CML_SURFACE_MESH ||
        !cml_mesh_surface_stretch(world->meshes[0], dp, du, 1, on, undeflected, err, &s))
        return;
    f->known = (struct cml_known_path){p, u, on, s.least, s.most, s.from, {.boundary = 0}};
    cml_intersect_mesh(world, 0, p, u, 1, CML_INFINITY, on, undeflected, &f->known.hit, &near_facet);
    f->aware = *world;
    f->aware.known_path = &f->known;
    f->world = &f->aware;
}

/* Ballistic packets start alike, do not interact in their first medium, and end at the plane behind it. They
 * can be counted instead of flown, unless each must be scored by itself (maps, facets, expected values,
 * fluence, rows). */
void cml_find_ballistic(struct cml_flight *f)
{
    const struct cml_world *world = f->world;
    const struct cml_packet *like = f->enters ? &f->inside : &f->start;
    struct cml_ballistic *ballistic = &f->ballistic;
    struct cml_packet packet = *like;
    struct cml_hit hit;
    if (!f->pencil || like->medium == 0 || f->to.phi || f->to.expected || f->factors ||
        cml_tallies_places(f->tally))
        return;
    const struct cml_boundary_intervals intervals = cml_find_intervals(world, like, CML_INFINITY);
    if (!cml_nearest_hit(world, &packet, intervals, &hit) || !cml_is_plane(world, hit.boundary) ||
        world->surfaces[hit.boundary].rough.kind || cml_is_touched(world, hit.boundary))
        return;
    if (!cml_transmit_like(world, like, &hit, &packet) || packet.fate == CML_FATE_ALIVE) return;
    ballistic->possible = 1;
    ballistic->path = hit.t;
    ballistic->mfp = world->media[like->medium].mfp;
    ballistic->crossings = like->crossings;
    ballistic->reflectance = cml_reflectance_at(world, like, &hit);
    ballistic->end = cml_termination_of(&packet);
}
