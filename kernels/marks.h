/* Scoring of fluence by marks along the paths of packets, and by interactions in dense media (P14). For the
 * host only: a device scores no fluence.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "bins.h"
#include "host_deposits.h"
#include "rng.h"
#include "source.h"
#include "types.h"

/* A straight part of a packet's path, from p along u. p: in the frame of the medium that it crosses. events:
 * interactions and boundary events before it, a number that no other part of the packet's path has. */
struct cml_stretch {
    cml_u64 index;
    struct cml_vec p, u;
    int medium;
    cml_u32 events;
    cml_u64 w; /* weight that flies along the stretch */
    real path; /* optical path of the packet at p; below 0: its clock has not started (P11) */
};

/* Limits for long stretches. From CML_MARKS_ONE_BY_ONE spacings on, or if the length may be infinite, only
 * marks within the grid's depths are placed. If more than CML_MARKS_DRAWN of these are left, only some of
 * them are placed. */
#define CML_MARKS_ONE_BY_ONE 64
#define CML_MARKS_DRAWN 1024

/* Returns the cell of the fluence of a packet's batch that holds p. A batch has cells beyond the grid, as
 * A_rz has. index: lower half of the packet's index; bins: depth of the medium's frame in bins of dz. */
CML_FN cml_u32 cml_mark_cell(const struct cml_setup *setup, cml_u32 index, struct cml_vec p, real bins)
{
    const int cell = cml_radial_bin(setup, p.x, p.y) * (setup->nz + 2) + cml_depth_bin(setup, p.z, bins);
    return index % CML_NUM_BATCHES * setup->marks.cells + (cml_u32)cell;
}

/* Scores a mark of weight w at p into its bins of r, z and time. path: optical path up to p. A mark outside
 * of the grid scores nothing. */
CML_FN void cml_mark_time(const struct cml_setup *setup, const struct cml_deposits *to, cml_u32 index,
                          struct cml_vec p, real bins, real path, cml_u64 w)
{
    const int ir = cml_radial_bin(setup, p.x, p.y), iz = cml_depth_bin(setup, p.z, bins) - 1;
    if (ir == setup->nr || iz < 0 || iz == setup->nz) return;
    const cml_u64 group = index % CML_NUM_GROUPS * (cml_u64)setup->nr + (cml_u64)ir,
                  place = group * (cml_u64)setup->nz + (cml_u64)iz;
    cml_add_shared(
        &to->phi_rzt[place * ((cml_u64)setup->gates.count + 1) + (cml_u64)cml_gate(setup->gates, path)], w);
}

/* Scores a mark of weight w into the voxel at p. A mark outside of the volume scores nothing. */
CML_FN void cml_mark_voxel(const struct cml_setup *setup, const struct cml_deposits *to, cml_u32 index,
                           struct cml_vec p, real bins, cml_u64 w)
{
    const cml_u64 voxel = cml_voxel(setup, p, bins);
    if (voxel < (cml_u64)setup->map.nx * (cml_u64)setup->map.ny * (cml_u64)setup->nz)
        cml_add_shared(&to->phi_xyz[voxel * CML_NUM_GROUPS + index % CML_NUM_GROUPS], w);
}

/* Scores a mark of weight w into bins of r and z, at the distance t (cm) along a stretch. */
CML_FN void cml_score_mark(const struct cml_world *world, const struct cml_deposits *to,
                           const struct cml_stretch *s, real t, cml_u64 w)
{
    const struct cml_vec p = cml_along(s->p, t, s->u);
    cml_add_mark(to, cml_mark_cell(&world->setup, (cml_u32)s->index, p, world->media[s->medium].bins), w);
}

/* True if marks score voxels or bins of time besides bins of r and z. */
CML_FN int cml_marks_score_more(const struct cml_deposits *to)
{
    return to->phi_xyz || to->phi_rzt;
}

/* Scores a mark of weight w at p into voxels and bins of time. path: optical path up to p. */
CML_FN void cml_mark_more(const struct cml_setup *setup, const struct cml_deposits *to, cml_u32 index,
                          struct cml_vec p, real bins, real path, cml_u64 w)
{
    if (to->phi_xyz) cml_mark_voxel(setup, to, index, p, bins, w);
    if (to->phi_rzt) cml_mark_time(setup, to, index, p, bins, path, w);
}

/* Scores a mark of weight w into voxels and bins of time, at the distance t (cm) along a stretch. */
CML_FN void cml_score_more(const struct cml_world *world, const struct cml_deposits *to,
                           const struct cml_stretch *s, real t, cml_u64 w)
{
    const CML_GLOBAL struct cml_medium *medium = &world->media[s->medium];
    const int leaves = s->medium == 0 && s->p.z == 0 && s->u.z < 0 && world->contacts.count;
    const struct cml_contact *port =
        leaves ? cml_contact_of(world, cml_contact_at(world, s->p.x, s->p.y)) : NULL;
    const real path = cml_path_after(s->path, t, port ? (real)port->n : medium->n);
    cml_mark_more(&world->setup, to, (cml_u32)s->index, cml_along(s->p, t, s->u), medium->bins, path, w);
}

/* Scores the marks of cml_mark_stretch into voxels and bins of time. A pass of its own keeps the loop of
 * cml_mark_stretch short. */
CML_RARE void cml_mark_stretch_more(const struct cml_world *world, const struct cml_deposits *to,
                                    const struct cml_stretch *s, real mark, real t)
{
    for (; mark < t; mark += world->setup.marks.spacing) cml_score_more(world, to, s, mark, s->w);
}

/* Finds the part of a stretch of length t within the depths of the grid or of the voxels: *begin to *end, cm
 * from its beginning. */
CML_FN void cml_clip_to_grid(const struct cml_world *world, const struct cml_stretch *s, real t, real *begin,
                             real *end)
{
    const struct cml_setup *setup = &world->setup;
    const real bins = world->media[s->medium].bins;
    const real top = (setup->marks.top - bins) / setup->per_dz - s->p.z,
               bottom = (setup->marks.bottom - bins) / setup->per_dz - s->p.z;
    const real to_top = top / s->u.z, to_bottom = bottom / s->u.z;
    const int level = s->u.z == 0, inside = (top <= 0) & (bottom >= 0);
    const real first = level ? (real)0 : (to_top < to_bottom ? to_top : to_bottom),
               last = level ? (inside ? t : (real)0) : (to_top < to_bottom ? to_bottom : to_top);
    *begin = first > 0 ? first : (real)0;
    *end = last < t ? last : t;
}

/* Returns the number of the first mark that does not come before `at`. mark: place of mark 0; all in cm. */
CML_FN int64_t cml_first_mark(double mark, double spacing, double at)
{
    const double most = 1073741824.0, number = (at - mark) / spacing;
    return number > 0 ? (int64_t)ceil(number < most ? number : most) : 0;
}

/* Scores the marks of a long stretch of length t: only those within the depths of the grid. If they are many,
 * only every 2^k-th scores, but with the weight of 2^k; a random word says which. Returns the distance from
 * the stretch's end to the next mark. */
CML_RARE real cml_mark_far(const struct cml_world *world, const struct cml_deposits *to,
                           const struct cml_stretch *s, real mark, real t)
{
    const double spacing = (double)world->setup.marks.spacing;
    real begin, end;
    cml_clip_to_grid(world, s, t, &begin, &end);
    const int64_t first = cml_first_mark(mark, spacing, begin), last = cml_first_mark(mark, spacing, end);
    int64_t every = 1;
    while ((last - first) / every > CML_MARKS_DRAWN) every *= 2;
    const cml_u32 word =
        every > 1 ? cml_draw(world->setup.stream, s->index, CML_PURPOSE_MARK, 1 + s->events).w[0] : 0;
    const int64_t begins = first + (int64_t)(word % (cml_u32)every);
    for (int64_t k = begins; k < last; k += every)
        cml_score_mark(world, to, s, (real)(mark + (double)k * spacing), s->w * (cml_u64)every);
    for (int64_t k = cml_marks_score_more(to) ? begins : last; k < last; k += every)
        cml_score_more(world, to, s, (real)(mark + (double)k * spacing), s->w * (cml_u64)every);
    if (!(t < CML_INFINITY)) return mark;
    const double ahead = mark + (double)cml_first_mark(mark, spacing, t) * spacing - (double)t;
    return ahead > 0 ? (real)ahead : (real)0;
}

/* Scores the marks of a stretch of length t. mark: distance of the first one from its beginning, cm. Returns
 * the distance of the next mark from its end. */
CML_FN real cml_mark_stretch(const struct cml_world *world, const struct cml_deposits *to,
                             const struct cml_stretch *s, real mark, real t)
{
    const real spacing = world->setup.marks.spacing;
    if (!(t < CML_MARKS_ONE_BY_ONE * spacing)) return cml_mark_far(world, to, s, mark, t);
    if (cml_marks_score_more(to)) cml_mark_stretch_more(world, to, s, mark, t);
    for (; mark < t; mark += spacing) cml_score_mark(world, to, s, mark, s->w);
    return mark - t;
}

/* Returns the stretch that a packet is about to fly or has flown, from `from` in its direction. */
CML_FN struct cml_stretch cml_stretch_of(const struct cml_packet *packet, struct cml_vec from, real path)
{
    const struct cml_stretch s = {
        packet->index, from, packet->u, packet->medium, packet->interactions + packet->boundary_events,
        packet->w,     path};
    return s;
}

/* True if a medium is dense: its interactions score fluence, and its flights do not (P14). mfp: mean free
 * path, cm. */
CML_FN int cml_is_dense(struct cml_marks marks, real mfp)
{
    return mfp * marks.per_spacing < 2;
}

/* Returns the score of an interaction in a dense medium: the weight w times the number of marks in a mean
 * free path. The score fits into 32 bits. */
CML_FN cml_u32 cml_interaction_score(struct cml_marks marks, real mfp, cml_u32 w)
{
    return (cml_u32)CML_FMA((real)w, mfp * marks.per_spacing, (real)0.5);
}

/* Scores the marks of a flight of t (cm) from `from`, where the optical path was `path`. The packet still has
 * the direction, medium and weight of the flight. */
CML_FN void cml_mark_path(const struct cml_world *world, const struct cml_deposits *to,
                          struct cml_packet *packet, struct cml_vec from, real path, real t)
{
    if (!cml_has_marks(to) || cml_is_dense(world->setup.marks, world->media[packet->medium].mfp)) return;
    const struct cml_stretch s = cml_stretch_of(packet, from, path);
    packet->mark = cml_mark_stretch(world, to, &s, packet->mark, t);
}

/* Scores an interaction. In a dense medium the interaction itself scores; in any other medium the marks of
 * the flight to it score. The packet has flown t (cm) from `from`, where its optical path was `path`, and
 * still has all its weight. */
CML_FN void cml_mark_interaction(const struct cml_world *world, const struct cml_deposits *to,
                                 struct cml_packet *packet, struct cml_vec from, real path, real t)
{
    const struct cml_setup *setup = &world->setup;
    const struct cml_medium *medium = &world->media[packet->medium];
    if (!cml_has_marks(to)) return;
    if (cml_is_dense(setup->marks, medium->mfp)) {
        const cml_u32 index = (cml_u32)packet->index,
                      w = cml_interaction_score(setup->marks, medium->mfp, packet->w);
        cml_add_mark(to, cml_mark_cell(setup, index, packet->p, medium->bins), w);
        cml_mark_more(setup, to, index, packet->p, medium->bins, cml_path_after(path, t, medium->n), w);
    } else {
        cml_mark_path(world, to, packet, from, path, t);
    }
}

/* Scores the flight to infinity of a packet that has left for good. */
CML_FN void cml_mark_last(const struct cml_world *world, const struct cml_deposits *to,
                          const struct cml_packet *packet)
{
    const struct cml_exit exit = cml_exit_of(&world->setup, packet->fate, 0, 0, 0, 0);
    if (!cml_has_marks(to) || !cml_has_left(&exit)) return;
    const struct cml_stretch s = cml_stretch_of(packet, packet->p, packet->path);
    (void)cml_mark_far(world, to, &s, packet->mark, CML_INFINITY);
}

/* Scores the light above a packet that starts below planes (P1): above the planes all light that comes down
 * to them and the specular part that goes up; in a clear first layer the light that goes to and fro. */
CML_FN void cml_mark_above(const struct cml_world *world, const struct cml_deposits *to,
                           const struct cml_packet *packet, real mark)
{
    const CML_GLOBAL struct cml_source *source = cml_source_of(world, packet->index);
    const struct cml_vec up = {0, 0, -1};
    struct cml_stretch s = {
        packet->index, packet->p, up, 0, 0, (cml_u64)CML_WEIGHT_ONE + source->specular, -1};
    s.p.z = 0;
    (void)cml_mark_far(world, to, &s, mark, CML_INFINITY);
    if (packet->medium < 2) return;
    s.medium = 1;
    s.w = (cml_u64)packet->w + 2 * (cml_u64)source->between;
    s.p.z = world->media[1].span;
    (void)cml_mark_far(world, to, &s, mark, s.p.z);
}

/* Places a packet's first mark at its launch, and scores the marks of the line along which the packet has
 * come. */
CML_FN void cml_mark_first(const struct cml_world *world, const struct cml_deposits *to,
                           struct cml_packet *packet)
{
    if (!cml_has_marks(to)) return;
    const real spacing = world->setup.marks.spacing;
    packet->mark =
        spacing * cml_uniform(cml_draw(world->setup.stream, packet->index, CML_PURPOSE_MARK, 0).w[0]);
    const real behind = spacing - packet->mark;
    if (cml_source_of(world, packet->index)->inside) return;
    if (packet->medium > 0) {
        cml_mark_above(world, to, packet, behind);
        return;
    }
    struct cml_stretch s = cml_stretch_of(packet, packet->p, -1);
    s.u.x = -s.u.x;
    s.u.y = -s.u.y;
    s.u.z = -s.u.z;
    (void)cml_mark_far(world, to, &s, behind, CML_INFINITY);
}
