/* Crossings of a ray with a radial heightfield: rings of cones about the z axis, searched in the order in
 * which the ray visits them.
 *
 *    from above: circles r_1 and r_2         along the ray: side * f, its height over the surface
 *
 *              . - ' ' - .                    |\                 .-.
 *            .   . - - .   .                  | \              .'   '.
 *    p o----+---+-------+---+----> u          |  '.         _.'       \
 *          t_1 t_2     t_3 t_4                |    '-.___.-'           \
 *            .   ' - - '   .                0 +---+----+-------+------+-x---> t
 *              ' - . . - '                       t_1  t_2     t_3    t_4  hit
 *
 *    cml_cone_go, span by span:  below 0 at its end  ---> the only root of the ring's cone in it
 *                                else convex         ---> may dip below 0 and come up again: the first root
 *                                else                ---> the next span, which shares the height at its end
 *
 * The cylinders r = r_i cut the ray into spans. In a span the height of the ray above the surface,
 *   f(t) = z(t) - (z_i + m_i (r(t) - r_i)),   r(t) = sqrt(a t^2 + 2 b t + c),
 * is convex or concave, so it has at most two roots. f at a shared radius is evaluated once, from that radius
 * itself, and both neighbours use it: no ray slips between two rings. The packet's side of the surface at the
 * start is known, and never computed. A packet that stands on a ring has the root t = 0, which is divided
 * out. The search needs no fixed small length.
 * The roots of a ring's cone solve (w + uz t)^2 = m^2 r(t)^2 with w = z - z_i + m r_i, i.e. A t^2 + 2 B t + C
 * = 0:
 *   A = uz^2 - m^2 a,  B = w uz - m^2 b,  C = (w - m r)(w + m r),
 *   B^2 - A C = m^2 (|w u_xy - uz p_xy|^2 - m^2 k^2),  k = x uy - y ux.
 * The last form has no cancellation for a ray along the axis.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "optics.h"
#include "port.h"

struct cml_rings {
    CML_GLOBAL const real *r, *z, *slope; /* [n], see struct cml_world */
    CML_GLOBAL const int *start;          /* [n] first rings of the parts that cml_ring_part numbers */
    real per_part;                        /* parts of the search table per cm */
    int n;
};

struct cml_ring {
    real r, z, slope;
};

/* Returns ring i of a boundary made of cones: radius, depth, and slope dz/dr up to the next ring. */
CML_FN struct cml_ring cml_ring_at(struct cml_rings rings, int i)
{
    const struct cml_ring ring = {rings.r[i], rings.z[i], rings.slope[i]};
    return ring;
}

/* A ray relative to the field's axis, with the terms that all rings need. side: +1 the packet is below the
 * surface (f > 0) and can only leave upwards; -1 it is above. */
struct cml_cone_ray {
    struct cml_vec p, u;
    real side;
    real a, b, c, r, k; /* r^2(t) = a t^2 + 2 b t + c; r = r(0); k = x uy - y ux */
};

/* Returns the ray from p along u, with the terms that all rings need. */
CML_FN struct cml_cone_ray cml_cone_ray_make(struct cml_vec p, struct cml_vec u, real side)
{
    struct cml_cone_ray ray;
    ray.p = p;
    ray.u = u;
    ray.side = side;
    ray.a = u.x * u.x + u.y * u.y;
    ray.b = p.x * u.x + p.y * u.y;
    ray.c = p.x * p.x + p.y * p.y;
    ray.r = CML_SQRT(ray.c);
    ray.k = p.x * u.y - p.y * u.x;
    return ray;
}

/* Returns the depth at which ring i ends; for the outermost ring its own depth. */
CML_FN real cml_ring_end(struct cml_rings rings, int i)
{
    return rings.z[i + 1 < rings.n ? i + 1 : i];
}

/* Returns z clamped to the depths at which a ring begins and ends. Without it, rounding between steep walls
 * would carry a packet out beyond the place where they meet, deeper with every reflection. */
CML_FN real cml_clamp_to_ring(real begin, real end, real z)
{
    const real low = begin < end ? begin : end, high = begin < end ? end : begin;
    return z > low ? (z < high ? z : high) : low;
}

/* Returns the part of the field that holds r, of its n - 1 > 0 equal parts. The result rises with r, whatever
 * rounding does. So rings that begin in an earlier or later part also begin before or behind r. */
CML_FN int cml_ring_part(real per_part, int n, real r)
{
    const int part = (int)(r * per_part);
    return part < n - 1 ? part : n - 2;
}

/* Returns the ring whose span holds r: the largest i with r_i <= r. In a field of evenly spaced rings it
 * is found without a search. */
CML_FN int cml_ring_of(struct cml_rings rings, real r)
{
    const int last = rings.n - 1;
    if (!(r < rings.r[last])) return last;
    const int part = cml_ring_part(rings.per_part, rings.n, r);
    int low = rings.start[part], high = rings.start[part + 1] + 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (rings.r[middle] <= r)
            low = middle;
        else
            high = middle;
    }
    return low;
}

#ifndef __OPENCL_VERSION__
/* Fills start[n] from the radii of n rings, and returns the number of parts per cm. */
static inline real cml_ring_starts(const real *r, int n, int *start)
{
    const real per_part = n > 1 ? (real)(n - 1) / r[n - 1] : (real)0;
    int ring = 0;
    for (int part = 0; part < n; part++) {
        while (ring + 1 < n && cml_ring_part(per_part, n, r[ring + 1]) < part) ring++;
        start[part] = ring;
    }
    return per_part;
}
#endif

/* Returns the t at which the ray leaves ring i. *next: i - 1 (inwards), i + 1 (outwards), or -1 (never, t is
 * infinite). While the ray moves inwards, it crosses r_i only if its least radius |k|/sqrt(a) is smaller. The
 * discriminant has two forms; the one for rays that go outwards does not cancel, so a tangent at r_(i+1)
 * leaves at once. */
CML_FN real cml_ring_exit(struct cml_rings rings, const struct cml_cone_ray *ray, int i, int inwards,
                          int *next)
{
    if (inwards && i > 0) {
        const real ri = rings.r[i];
        const real square = ray->a * ri * ri - ray->k * ray->k;
        if (square > 0) {
            *next = i - 1;
            return (ray->r - ri) * (ray->r + ri) / (CML_SQRT(square) - ray->b);
        }
    }
    *next = i + 1 < rings.n && ray->a > 0 ? i + 1 : -1;
    if (*next < 0) return CML_INFINITY;
    const real ro = rings.r[i + 1], gap = (ro - ray->r) * (ro + ray->r);
    const real square = ray->b > 0 ? ray->b * ray->b + ray->a * gap : ray->a * ro * ro - ray->k * ray->k;
    const real root = square > 0 ? CML_SQRT(square) : (real)0;
    return ray->b > 0 ? gap / (root + ray->b) : (root - ray->b) / ray->a;
}

/* Returns side * f at the end t of a span of ring i. next: the ring that begins at this radius or ends there;
 * -1: none, and r(t) is computed. */
CML_FN real cml_ring_height(struct cml_rings rings, const struct cml_cone_ray *ray, int i, int next, real t)
{
    const real z = ray->p.z + t * ray->u.z;
    if (next >= 0) return ray->side * (z - rings.z[next > i ? next : i]);
    const real x = ray->p.x + t * ray->u.x, y = ray->p.y + t * ray->u.y;
    const real r = CML_SQRT(x * x + y * y); /* a t^2 + 2 b t + c would cancel near the axis, even below 0 */
    return ray->side * (z - rings.z[i] - rings.slope[i] * (r - rings.r[i]));
}

/* The quadratic of a ring's cone. C is left to the caller that needs it. */
struct cml_cone_quadratic {
    real w, A, B, D; /* A, B and discriminant D = B^2 - A C of the quadratic */
};

/* Returns the coefficients of the quadratic equation for the distances at which a ray meets the cone of a
 * ring. */
CML_FN struct cml_cone_quadratic cml_ring_quadratic(struct cml_ring ring, const struct cml_cone_ray *ray)
{
    const real m = ring.slope, mm = m * m, w = ray->p.z - ring.z + m * ring.r;
    const real across_x = w * ray->u.x - ray->u.z * ray->p.x, across_y = w * ray->u.y - ray->u.z * ray->p.y;
    const struct cml_cone_quadratic q = {
        w, ray->u.z * ray->u.z - mm * ray->a, w * ray->u.z - mm * ray->b,
        mm * (across_x * across_x + across_y * across_y - mm * ray->k * ray->k)};
    return q;
}

/* True if the ray goes below the real nappe of ring i and comes up again, with its deepest point in (t0, t1).
 * *t: where it goes below; *half_root_gap: the distance from there to the deepest point. A < 0 puts both
 * roots on one nappe.
 * The height at the deepest point decides, and gives the root's distance. A discriminant would have lost
 * these digits where the ray just touches the cone. */
CML_FN int cml_ring_dips(struct cml_rings rings, const struct cml_cone_ray *ray, int i, real t0, real t1,
                         real *t, real *half_root_gap)
{
    const struct cml_cone_quadratic q = cml_ring_quadratic(cml_ring_at(rings, i), ray);
    if (!(q.A < 0)) return 0;
    const real m = rings.slope[i], middle = -q.B / q.A;
    if (!(middle > t0 && middle < t1)) return 0;
    const real x = ray->p.x + middle * ray->u.x, y = ray->p.y + middle * ray->u.y;
    const real r = CML_SQRT(x * x + y * y);
    const real height = ray->p.z + middle * ray->u.z - rings.z[i] - m * (r - rings.r[i]);
    if (!(ray->side * height < 0)) return 0;
    *half_root_gap = CML_SQRT(height * (height + 2 * m * r) / -q.A);
    *t = middle - *half_root_gap;
    return 1;
}

/* Returns the root of a ring's cone, of slope other than 0, at which the ray leaves its side: of both roots
 * the one where side * f falls. The caller knows from a change of sign or a dip that this root is real. So a
 * discriminant below 0 comes from rounding, and the ray passes through the tip. standing: t = 0 is a root and
 * is divided out. *half_root_gap: half the distance between both roots. */
CML_FN real cml_ring_sloped_root(struct cml_ring ring, const struct cml_cone_ray *ray, int standing,
                                 real *half_root_gap)
{
    const real m = ring.slope;
    const struct cml_cone_quadratic c = cml_ring_quadratic(ring, ray);
    const real C = standing ? (real)0 : (c.w - m * ray->r) * (c.w + m * ray->r);
    const real root = standing ? (c.B < 0 ? -c.B : c.B) : CML_SQRT(c.D > 0 ? c.D : (real)0);
    const real q = ray->side * m > 0 ? -c.B - root : -c.B + root;
    const real q_other = ray->side * m > 0 ? -c.B + root : -c.B - root;
    const int larger = (q < 0 ? -q : q) >= (q_other < 0 ? -q_other : q_other);
    *half_root_gap = root / (c.A < 0 ? -c.A : c.A);
    return (larger ? q : C) / (larger ? c.A : q_other);
}

/* Finds the root in a ring of any slope, where a ray meets the ring's cone. Returns 0 if there is none.
 * standing: 1 if the packet stands on the ring. *t may lie outside the span. */
CML_FN int cml_ring_root(struct cml_rings rings, const struct cml_cone_ray *ray, int i, int standing, real *t,
                         real *half_root_gap)
{
    const struct cml_ring ring = cml_ring_at(rings, i);
    *half_root_gap = CML_INFINITY;
    if (ring.slope == 0) {
        if (!(ray->side * ray->u.z < 0)) return 0;
        *t = standing ? (real)0 : (ring.z - ray->p.z) / ray->u.z;
        return 1;
    }
    *t = cml_ring_sloped_root(ring, ray, standing, half_root_gap);
    return 1;
}

/* Returns the place in [t0, t1] where side * f falls below 0, by bisection from t on; t0 if it is below 0
 * there already. If it falls before t, the search goes back from t in steps that do not depend on t0. So a
 * march that begins later finds the same place. */
CML_FN real cml_ring_search(struct cml_rings rings, const struct cml_cone_ray *ray, int i, real t0, real t1,
                            real t)
{
    real low = t, high = t1;
    if (cml_ring_height(rings, ray, i, -1, t0) < 0) return t0;
    for (real back = CML_EPSILON * t; low > t0 && cml_ring_height(rings, ray, i, -1, low) < 0; back *= 2) {
        high = low;
        low = t - back > t0 ? t - back : t0;
    }
    for (int n = 0; n < 64; n++) {
        const real middle = low + (high - low) / 2;
        if (!(middle > low && middle < high)) break;
        if (cml_ring_height(rings, ray, i, -1, middle) < 0)
            high = middle;
        else
            low = middle;
    }
    return low;
}

/* Improves a root by one Newton step on the height itself. The quadratic's root loses digits if a ray from
 * far away passes close to the apex; the height at the root does not. If the ray just touches the cone, or
 * lies almost in it, the root may have lost all digits, and the step goes anywhere. Returns 1 if the step is
 * small against half_root_gap and the distance from the axis, between which the slope changes; only then
 * *better may be used. */
CML_FN int cml_ring_newton(struct cml_ring ring, const struct cml_cone_ray *ray, real t0, real t1, real t,
                           real half_root_gap, real *better)
{
    const real m = ring.slope;
    const real x = ray->p.x + t * ray->u.x, y = ray->p.y + t * ray->u.y, r = CML_SQRT(x * x + y * y);
    const real height = ray->p.z + t * ray->u.z - ring.z - m * (r - ring.r);
    const real rate = ray->u.z - m * (x * ray->u.x + y * ray->u.y) / r;
    const real step = height / rate, moved = t - step;
    const int small = 16 * (step < 0 ? -step : step) <= (half_root_gap < r ? half_root_gap : r);
    *better = moved;
    return (r > 0) & (ray->side * rate < 0) & small & (moved >= t0) & (moved <= t1);
}

/* Returns the root after Newton's step. If the step is of no use, the sign of the height decides by
 * bisection.
 * A packet that stands on the ring has no sign at its start. For it Newton's step also removes its distance
 * from the surface, which would else grow with every reflection along a hollow. The sign half-way tells if
 * the packet has left the surface before at all: beside a tip the root may be that of the cone's other
 * nappe. */
CML_FN real cml_ring_polish(struct cml_rings rings, const struct cml_cone_ray *ray, int i, real t0, real t1,
                            int standing, real t, real half_root_gap)
{
    real better;
    if (cml_ring_newton(cml_ring_at(rings, i), ray, t0, t1, t, half_root_gap, &better)) return better;
    const int apart = standing && !(cml_ring_height(rings, ray, i, -1, t / 2) < 0);
    return cml_ring_search(rings, ray, i, apart ? t / 2 : t0, t1, t);
}

/* Returns the root, or the nearer end of the span [t0, t1] if the root lies outside the span. */
CML_FN real cml_clamp_to_span(real root, real t0, real t1)
{
    return root > t0 ? (root < t1 ? root : t1) : t0;
}

/* True if rounding may have put the packet on any side of the field's tip. */
CML_FN int cml_ring_in_tip(struct cml_rings rings, const struct cml_cone_ray *ray, int i)
{
    return i == 0 && rings.r[0] == 0 && ray->r <= 8 * CML_EPSILON * (CML_FABS(ray->p.z) + rings.r[1]);
}

/* Searches one span [t0, t1] of ring i. end: side * f at t1. The surface is crossed if `end` is negative, or
 * if side * f dips below 0 in between, which only a convex side * f can. Returns 1, and *t in [t0, t1], if
 * the surface is crossed. */
CML_FN int cml_ring_span(struct cml_rings rings, const struct cml_cone_ray *ray, int i, real end,
                         int standing, real t0, real t1, real *t)
{
    real root, half_root_gap;
    if (!(end < 0)) {
        const int convex = ray->side * rings.slope[i] < 0;
        if (standing || !convex || !cml_ring_dips(rings, ray, i, t0, t1, &root, &half_root_gap)) return 0;
        t1 = root + half_root_gap;
    } else if (!cml_ring_root(rings, ray, i, standing, &root, &half_root_gap)) {
        return 0;
    }
    if (standing && !(root >= 0 && root <= t1)) {
        /* The sign at t1 comes from rounding: the packet has just left the ring. At the tip this proves
         * nothing, because the packet may have been on any side of it. */
        *t = t0;
        return cml_ring_in_tip(rings, ray, i);
    }
    root = cml_clamp_to_span(root, t0, t1);
    *t = cml_ring_polish(rings, ray, i, t0, t1, standing, root, half_root_gap);
    return 1;
}

/* Finds the crossing of a ray parallel to the axis; 0: there is none before t_max. A packet that stands on
 * the surface crosses nothing. The ray stays at one radius, so its height is linear in t. */
CML_FN int cml_cone_hit_vertical(struct cml_rings rings, const struct cml_cone_ray *ray, int i, int standing,
                                 real t_max, real *t)
{
    if (!(ray->side * ray->u.z < 0) || standing) return 0;
    const real z = rings.z[i] + rings.slope[i] * (ray->r - rings.r[i]);
    const real root = (z - ray->p.z) / ray->u.z;
    *t = root > 0 ? root : (real)0;
    return *t < t_max;
}

/* The state of a search: a ray on its way from ring to ring, now in the span [t0, t1] of one ring. */
struct cml_cone_march {
    struct cml_cone_ray ray;
    int ring, inwards, standing;
    real t0, t1;
};

/* Begins a search at t_min: returns the march with the ring that the ray is in there, or stands on. */
CML_FN struct cml_cone_march cml_cone_begin(struct cml_rings rings, struct cml_vec p, struct cml_vec u,
                                            real side, real t_min, int on_ring)
{
    const struct cml_cone_ray ray = cml_cone_ray_make(p, u, side);
    const real x = p.x + t_min * u.x, y = p.y + t_min * u.y;
    const int standing = on_ring >= 0,
              ring = standing ? on_ring : cml_ring_of(rings, CML_SQRT(x * x + y * y));
    const struct cml_cone_march march = {ray, ring, ray.b + t_min * ray.a < 0, standing, t_min, t_min};
    return march;
}

enum cml_cone_verdict {
    CML_CONE_MISSED,
    CML_CONE_HIT,
    CML_CONE_ENTERED, /* the ray crosses in the span, for the first time, at its only root */
};

#ifndef __OPENCL_VERSION__
/* Spans are searched one by one until CML_CONE_ALONE have been passed, then CML_CONE_TOGETHER at a time in
 * vector loops. */
#define CML_CONE_ALONE 3
#define CML_CONE_TOGETHER 16

/* Skips spans in which a march that stands on no ring provably meets nothing. The arithmetic is that of
 * cml_cone_go. A span is skipped if it ends before t_max and on the packet's side, and if the ray does not
 * come closest to the ring's cone within it. Moves the march to the first span that is not skipped, and
 * returns the number of spans skipped. The caller makes sure that CML_CONE_TOGETHER rings lie ahead. */
__attribute__((always_inline)) static inline int
cml_cone_skip_way(struct cml_rings rings, struct cml_cone_march *march, real t_max, const int inwards)
{
    const struct cml_cone_ray ray = march->ray;
    const int from = march->ring, rising = ray.b > 0, outwards = !inwards;
    real t[CML_CONE_TOGETHER + 1];
    int keeps_side[CML_CONE_TOGETHER], first = CML_CONE_TOGETHER;
    t[0] = march->t0;
#pragma omp simd
    for (int k = 0; k < CML_CONE_TOGETHER; k++) {
        const int at = inwards ? from - k : from + 1 + k; /* ring whose radius ends the span */
        const real r = rings.r[at], gap = (r - ray.r) * (r + ray.r);
        const real turning = ray.a * r * r - ray.k * ray.k,
                   square = (outwards & rising) ? ray.b * ray.b + ray.a * gap : turning;
        const real root = CML_SQRT(square > 0 ? square : (real)0);
        const real in = (ray.r - r) * (ray.r + r) / (root - ray.b),
                   out = (rising ? gap : root - ray.b) / (rising ? root + ray.b : ray.a),
                   end = inwards ? in : out;
        const real z = ray.p.z + end * ray.u.z;
        keeps_side[k] = (ray.side * (z - rings.z[at]) < 0 ? 0 : 1) & (outwards | (square > 0));
        t[k + 1] = end;
    }
#pragma omp simd reduction(min : first)
    for (int k = 0; k < CML_CONE_TOGETHER; k++) {
        const int i = inwards ? from - k : from + k;
        const real m = rings.slope[i], mm = m * m, w = ray.p.z - rings.z[i] + m * rings.r[i];
        const real A = ray.u.z * ray.u.z - mm * ray.a, B = w * ray.u.z - mm * ray.b, middle = -B / A;
        const int closest = (ray.side * m < 0) & (A < 0) & (middle > t[k]) & (middle < t[k + 1]);
        const int passes = keeps_side[k] & (t[k] < t[k + 1]) & (t[k + 1] < t_max) & !closest;
        const int stop = k + passes * CML_CONE_TOGETHER;
        first = stop < first ? stop : first;
    }
    march->ring = inwards ? from - first : from + first;
    march->t0 = t[first];
    return first;
}

/* Moves the march past spans that meet nothing. It tests CML_CONE_TOGETHER spans at a time, and ends when a
 * span needs a closer search or fewer rings than that lie ahead. */
__attribute__((noinline, unused)) static void cml_cone_skip(struct cml_rings rings,
                                                            struct cml_cone_march *march, real t_max)
{
    int skipped;
    do {
        const int enough =
            march->inwards ? march->ring >= CML_CONE_TOGETHER : march->ring + CML_CONE_TOGETHER < rings.n;
        if (!enough) return;
        skipped = march->inwards ? cml_cone_skip_way(rings, march, t_max, 1)
                                 : cml_cone_skip_way(rings, march, t_max, 0);
    } while (skipped == CML_CONE_TOGETHER);
}
#else
#define CML_CONE_ALONE 1
/* On a device the other items of a work-group would wait. */
#define cml_cone_skip(rings, march, t_max) ((void)0)
#endif

/* Moves a march to the first crossing before t_max: *t, on march->ring. leave_roots: 1 leaves most roots to
 * the caller, with the verdict CML_CONE_ENTERED. */
CML_FN enum cml_cone_verdict cml_cone_go(struct cml_rings rings, struct cml_cone_march *march, real t_max,
                                         int leave_roots, real *t)
{
    const struct cml_cone_ray *ray = &march->ray;
    if (!(ray->a > 0))
        return cml_cone_hit_vertical(rings, ray, march->ring, march->standing, t_max, t) ? CML_CONE_HIT
                                                                                         : CML_CONE_MISSED;
    for (int spans = 1;; spans++) {
        const int i = march->ring, standing = march->standing;
        const real t0 = march->t0;
        int next;
        real t1 = cml_ring_exit(rings, ray, i, march->inwards, &next);
        if (next > i) march->inwards = 0;
        const int last = !(t1 < t_max);
        if (last) next = -1;
        t1 = last ? t_max : (t1 > t0 ? t1 : t0);
        march->t1 = t1;
        if (next < 0 && rings.slope[i] == 0) {
            real half_root_gap;
            const int plane =
                cml_ring_root(rings, ray, i, standing, t, &half_root_gap) && !standing && *t < t1;
            if (plane) *t = *t > t0 ? *t : t0;
            return plane ? CML_CONE_HIT : CML_CONE_MISSED;
        }
        const real end = cml_ring_height(rings, ray, i, next, t1);
        if (leave_roots && end < 0 && !standing && rings.slope[i] != 0) return CML_CONE_ENTERED;
        if (cml_ring_span(rings, ray, i, end, standing, t0, t1, t))
            return *t < t_max ? CML_CONE_HIT : CML_CONE_MISSED;
        if (next < 0) return CML_CONE_MISSED;
        march->standing = 0;
        march->ring = next;
        march->t0 = t1;
        if (spans % CML_CONE_ALONE == 0) cml_cone_skip(rings, march, t_max);
    }
}

/* Finds the first crossing of the surface with t_min <= t < t_max (which may be infinite). There must be none
 * before t_min. p: relative to the axis, in the boundary's frame. on_ring: the ring that the packet stands on
 * (then t_min must be 0), or -1. Returns 1, *t and *ring if there is a crossing, else 0. */
CML_FN int cml_cone_hit(struct cml_rings rings, struct cml_vec p, struct cml_vec u, real side, real t_min,
                        real t_max, int on_ring, real *t, int *ring)
{
    struct cml_cone_march march = cml_cone_begin(rings, p, u, side, t_min, on_ring);
    const enum cml_cone_verdict verdict = cml_cone_go(rings, &march, t_max, 0, t);
    *ring = march.ring;
    return verdict == CML_CONE_HIT;
}

/* Returns the unit normal, pointing up (against z), of a cone of slope m at (x, y). r = sqrt(x^2 + y^2) >
 * 0. */
CML_FN struct cml_vec cml_cone_normal_of_slope(real m, real x, real y, real r)
{
    const real k = (real)1 / CML_SQRT((real)1 + m * m);
    const struct cml_vec up = {m * k * (x / r), m * k * (y / r), -k};
    return up;
}

/* Returns the unit normal of ring i alone, pointing up, at a point relative to the axis. On the axis it is
 * the axis itself. This normal decides on which side of the ring a direction goes. */
CML_FN struct cml_vec cml_cone_facet(struct cml_rings rings, int i, real x, real y)
{
    const struct cml_vec axis = {0, 0, -1};
    const real r = CML_SQRT(x * x + y * y);
    return r > 0 ? cml_cone_normal_of_slope(rings.slope[i], x, y, r) : axis;
}

/* Returns the unit normal of the surface at a point of ring i: the ring's own normal, or exactly on a ridge
 * the mean of both rings' normals. */
CML_FN struct cml_vec cml_cone_normal(struct cml_rings rings, int i, real x, real y)
{
    const real r = CML_SQRT(x * x + y * y);
    const struct cml_vec up = cml_cone_facet(rings, i, x, y);
    const int neighbour = r == rings.r[i] ? i - 1 : (i + 1 < rings.n && r == rings.r[i + 1] ? i + 1 : i);
    if (neighbour == i || neighbour < 0) return up;
    const struct cml_vec other = cml_cone_normal_of_slope(rings.slope[neighbour], x, y, r);
    const struct cml_vec sum = cml_along(up, 1, other);
    const real k = (real)1 / CML_SQRT(cml_dot(sum, sum));
    const struct cml_vec mean = {k * sum.x, k * sum.y, k * sum.z};
    return mean;
}
