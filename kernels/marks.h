/* Fluence, by interactions and by marks along the paths of packets (P14). A device has none.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "bins.h"
#include "host_deposits.h"
#include "rng.h"
#include "source.h"
#include "types.h"

/* A straight part of a packet's path: from p along u, p in the frame of the medium that it crosses. events:
 * those before it, which no other part of the path has as many of. */
struct cml_stretch {
    cml_u64 index;
    struct cml_vec p, u;
    int medium;
    cml_u32 events;
    cml_u64 w; /* weight that flies along it */
    real path; /* optical path of the packet at p; below 0: its clock has not started (P11) */
};

/* More than so many marks, or a length that may be infinite, and they are placed one by one no more. */
#define CML_MARKS_ONE_BY_ONE 64
#define CML_MARKS_DRAWN 1024

/* Cell of the fluence that a place of a packet belongs to; bins: of the medium. Those of its batch have cells
 * beyond the grid as A_rz has. */
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

/* What a mark at p scores, weight w, into the voxel there; nothing outside of the volume. */
CML_FN void cml_mark_voxel(const struct cml_setup *setup, const struct cml_deposits *to, cml_u32 index,
                           struct cml_vec p, real bins, cml_u64 w)
{
    const cml_u64 voxel = cml_voxel(setup, p, bins);
    if (voxel < (cml_u64)setup->map.nx * (cml_u64)setup->map.ny * (cml_u64)setup->nz)
        cml_add_shared(&to->phi_xyz[voxel * CML_NUM_GROUPS + index % CML_NUM_GROUPS], w);
}

CML_FN void cml_score_mark(const struct cml_world *world, const struct cml_deposits *to,
                           const struct cml_stretch *s, real t, cml_u64 w)
{
    const struct cml_vec p = cml_along(s->p, t, s->u);
    cml_add_mark(to, cml_mark_cell(&world->setup, (cml_u32)s->index, p, world->media[s->medium].bins), w);
}

/* True where marks score voxels or bins of time besides bins of r and z. */
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

CML_FN void cml_score_more(const struct cml_world *world, const struct cml_deposits *to,
                           const struct cml_stretch *s, real t, cml_u64 w)
{
    const CML_GLOBAL struct cml_medium *medium = &world->media[s->medium];
    const real path = cml_path_after(s->path, t, medium->n);
    cml_mark_more(&world->setup, to, (cml_u32)s->index, cml_along(s->p, t, s->u), medium->bins, path, w);
}

/* Scores the marks of cml_mark_stretch into voxels and bins of time. A pass of its own keeps the loop of
 * cml_mark_stretch short. */
CML_RARE void cml_mark_stretch_more(const struct cml_world *world, const struct cml_deposits *to,
                                    const struct cml_stretch *s, real mark, real t)
{
    for (; mark < t; mark += world->setup.marks.spacing) cml_score_more(world, to, s, mark, s->w);
}

/* The part of a stretch of length t whose depths are those of the grid, or of voxels: from *begin to *end,
 * cm. */
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

/* Number of the first mark that is not before `at`. */
CML_FN int64_t cml_first_mark(double mark, double spacing, double at)
{
    const double most = 1073741824.0, number = (at - mark) / spacing;
    return number > 0 ? (int64_t)ceil(number < most ? number : most) : 0;
}

/* Marks of a long stretch: only those within the depths of the grid, and of many only every 2^k-th, which
 * then counts for as many; which of them is random. */
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

/* Scores the marks of a stretch of length t, the first of which is `mark` (cm) from its beginning; returns
 * how far the next one is from its end. */
CML_FN real cml_mark_stretch(const struct cml_world *world, const struct cml_deposits *to,
                             const struct cml_stretch *s, real mark, real t)
{
    const real spacing = world->setup.marks.spacing;
    if (!(t < CML_MARKS_ONE_BY_ONE * spacing)) return cml_mark_far(world, to, s, mark, t);
    if (cml_marks_score_more(to)) cml_mark_stretch_more(world, to, s, mark, t);
    for (; mark < t; mark += spacing) cml_score_mark(world, to, s, mark, s->w);
    return mark - t;
}

CML_FN struct cml_stretch cml_stretch_of(const struct cml_packet *packet, struct cml_vec from, real path)
{
    const struct cml_stretch s = {
        packet->index, from, packet->u, packet->medium, packet->interactions + packet->boundary_events,
        packet->w,     path};
    return s;
}

/* Whether interactions of a medium with this mean free path score, and its flights do not. */
CML_FN int cml_is_dense(struct cml_marks marks, real mfp)
{
    return mfp * marks.per_spacing < 2;
}

/* What an interaction of a packet of weight w scores in a dense medium: what all marks of a mean free path
 * would. It has 32 bits. */
CML_FN cml_u32 cml_interaction_score(struct cml_marks marks, real mfp, cml_u32 w)
{
    return (cml_u32)CML_FMA((real)w, mfp * marks.per_spacing, (real)0.5);
}

/* The packet flies t (cm) from `from`, where its optical path was `path`; its direction, medium and weight
 * are still those of the flight. */
CML_FN void cml_mark_path(const struct cml_world *world, const struct cml_deposits *to,
                          struct cml_packet *packet, struct cml_vec from, real path, real t)
{
    if (!cml_has_marks(to) || cml_is_dense(world->setup.marks, world->media[packet->medium].mfp)) return;
    const struct cml_stretch s = cml_stretch_of(packet, from, path);
    packet->mark = cml_mark_stretch(world, to, &s, packet->mark, t);
}

/* The packet has flown t (cm) from `from`, where its optical path was `path`, to its interaction, and has all
 * its weight yet. */
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

/* The flight of a packet that has left for good, to infinity. */
CML_FN void cml_mark_last(const struct cml_world *world, const struct cml_deposits *to,
                          const struct cml_packet *packet)
{
    const struct cml_exit exit = cml_exit_of(&world->setup, packet->fate, 0, 0, 0, 0);
    if (!cml_has_marks(to) || !cml_has_left(&exit)) return;
    const struct cml_stretch s = cml_stretch_of(packet, packet->p, packet->path);
    (void)cml_mark_far(world, to, &s, packet->mark, CML_INFINITY);
}

/* A packet that starts below planes: what has come down to them and what goes up for good, and in a clear
 * first layer what goes to and fro there. */
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

/* At the launch: places the first mark, and scores those of the line that the packet has come along. */
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
