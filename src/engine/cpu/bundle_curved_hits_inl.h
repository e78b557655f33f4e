/* Code, included by bundle_curved_reach_inl.h and bundle_curved_cross_inl.h: lanes near curved boundaries,
 * step 3. Packets that meet one boundary are gathered. Vector loops find roots and normals of rings, and
 * reflect or refract.
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_lanes_inl.h"
#include "engine/cpu/bundle_loops_inl.h"

/* Packets that meet one boundary from one side, a structure of arrays with entries 0 to count - 1. Positions
 * are in the boundary's frame, x and y from the scene's origin, cm. Loops go over whole vectors, so entries
 * behind the packets may hold anything. */
struct cml_hits {
    int count;
    _Alignas(64) int lane[CML_LANES], primitive[CML_LANES];
    real x[CML_LANES], y[CML_LANES], z[CML_LANES], ux[CML_LANES], uy[CML_LANES], uz[CML_LANES];
    /* Members for hits on rings: */
    int known[CML_LANES]; /* 1: t is known; 0: t is the root in [t0, t1] */
    real ring_r[CML_LANES], ring_z[CML_LANES], ring_end[CML_LANES], slope[CML_LANES];
    real t0[CML_LANES], t1[CML_LANES], t_max[CML_LANES];
    real t[CML_LANES];
    cml_u32 index_low[CML_LANES], index_high[CML_LANES], crossings[CML_LANES], reflection[CML_LANES];
    /* Results of the vector loops: */
    int doubtful[CML_LANES]; /* 1: the hit must be searched again, by itself */
    int through[CML_LANES];
    real normal_x[CML_LANES], normal_y[CML_LANES], normal_z[CML_LANES];
};

/* Finds the root of cml_ring_span in [t0, t1] (cm along the ray) of a ray that enters the ring's cone and
 * does not stand on it. The slope is not 0. Returns 0 if Newton's method fails, so that a search is
 * needed. */
static inline int cml_entry_root(struct cml_ring ring, struct cml_vec p, struct cml_vec u, real side, real t0,
                                 real t1, real *root)
{
    const struct cml_cone_ray ray = cml_cone_ray_make(p, u, side);
    real half_root_gap;
    const real first = cml_clamp_to_span(cml_ring_sloped_root(ring, &ray, 0, &half_root_gap), t0, t1);
    return cml_ring_newton(ring, &ray, t0, t1, first, half_root_gap, root);
}

/* Finds for all gathered hits where packets meet the cone of their ring, in one vector loop. Sets t, normals
 * and the place. A hit is doubtful, and done again alone, if the root must be searched for or lies at the
 * tip. */
CML_LOOP void cml_hits_refine_rings(const struct cml_world *world, real side, struct cml_hits *h)
{
    const int size = cml_whole_vectors(h->count);
#pragma omp simd
    for (int k = 0; k < size; k++) {
        const struct cml_vec p = {h->x[k], h->y[k], h->z[k]}, u = {h->ux[k], h->uy[k], h->uz[k]};
        const struct cml_ring ring = {h->ring_r[k], h->ring_z[k], h->slope[k]};
        const real given = h->t[k], t_max = h->t_max[k];
        const int known = h->known[k];
        real better;
        const int good =
            cml_entry_root(ring, cml_from_scene_axis(world, p), u, side, h->t0[k], h->t1[k], &better);
        const real t = known ? given : better;
        const struct cml_vec point = cml_along(p, t, u), q = cml_from_scene_axis(world, point);
        const real r = CML_SQRT(q.x * q.x + q.y * q.y);
        const struct cml_vec up = cml_cone_normal_of_slope(ring.slope, q.x, q.y, r);
        h->t[k] = t;
        h->doubtful[k] = !((known | (good & (better < t_max))) & (r > 0));
        h->x[k] = point.x;
        h->y[k] = point.y;
        h->z[k] = cml_clamp_to_ring(ring.z, h->ring_end[k], point.z);
        h->normal_x[k] = up.x;
        h->normal_y[k] = up.y;
        h->normal_z[k] = up.z;
    }
}

/* Reflects or refracts at the hits between unequal indices n1 (near) and n2 (P5), as cml_reflect_or_refract
 * does if normal and facet are the same: fills through, and turns ux, uy, uz. A direction can be on the wrong
 * side of the facet only if it lies in the facet's plane but for rounding. A packet that rounding has put
 * before the facet, and that already leads away from it, goes on as it was: mirrored, it would run through
 * the facet. Returns the number of directions that the facet has overruled, without doubtful hits. */
CML_LOOP int cml_hits_reflect_or_refract(const struct cml_setup *setup, real side, real n1, real n2,
                                         struct cml_hits *h)
{
    const struct cml_stream stream = setup->stream;
    /* Number of first reflections that draw from the lattice. */
    const cml_u32 even = setup->stream.lattice ? CML_LATTICE_REFLECTIONS : 0u;
    const int count = h->count, size = cml_whole_vectors(count);
    int overruled = 0;
#pragma omp simd reduction(+ : overruled)
    for (int k = 0; k < size; k++) {
        const struct cml_vec u = {h->ux[k], h->uy[k], h->uz[k]};
        const struct cml_vec up = {h->normal_x[k], h->normal_y[k], h->normal_z[k]};
        const struct cml_block draw =
            cml_threefry(stream, h->index_low[k], h->index_high[k], h->crossings[k], CML_PURPOSE_BOUNDARY);
        const cml_u32 word = cml_even_or_random(h->crossings[k] < even, h->reflection[k], draw.w[0]);
        int through;
        const struct cml_vec v = cml_boundary_direction(u, up, side, n1, n2, cml_uniform(word), &through);
        const real leaving = side * cml_dot(v, up);
        const int wrong = (through & (leaving < 0)) | (!through & (leaving > 0));
        const int goes_on = wrong & !through & (side * cml_dot(u, up) < 0);
        h->ux[k] = goes_on ? u.x : v.x;
        h->uy[k] = goes_on ? u.y : v.y;
        h->uz[k] = goes_on ? u.z : v.z;
        h->through[k] = through;
        overruled += wrong & !h->doubtful[k] & (k < count);
    }
    return overruled;
}
