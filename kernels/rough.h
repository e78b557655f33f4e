/* The event of one packet at a rough boundary (P20): its walk on Smith's surface of tiny facets. Weight 1
 * comes in, and one packet of weight 1 goes out, on this side or the other.
 *
 *         v \      / v (leaves: no facet above hides it)
 *            \    /            height is known by u = C1(h) only, the share of the surface that lies lower:
 *         m ^ \  /             u = 1 on top; here e = -ln u, so that u near 1 keeps its digits
 *       ____|__\/_   ___
 *      /    |    \  /   \      1  fly to the next facet: u' = u xi1^(-1 / Lambda(v)); up and u' >= 1: leave
 *     /           \/     \     2  draw its normal m as seen from -v
 *                              3  reflect about m, or refract: then the same walk goes on beyond, upside down
 *
 * Heitz, Hanika, d'Eon, Dachsbacher, Multiple-scattering microfacet BSDFs with the Smith model, SIGGRAPH
 * 2016. The functions here know nothing of packets, surfaces and media.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lattice.h"
#include "optics.h"
#include "types.h"

/* Most facets that a packet may meet in one event. */
#define CML_ROUGH_LIMIT 1000
#define CML_ROUGH_FN CML_FN __attribute__((always_inline)) /* inlined in vector loops too, however large */

/* ---- functions of the error integral ---- */

/* Returns exp(x^2) erfc(x) for x >= 0. Relative error < 5e-7 in float (unit.rough): a polynomial in (x - 2) /
 * (x + 2), fitted at Chebyshev's nodes, after Shepherd, Laframboise, Math. Comput. 36, 249 (1981). */
CML_ROUGH_FN real cml_erfcx(real x)
{
#ifdef CML_DOUBLE
    const double q = 1 / (x * x);
    return x < 26 ? exp(x * x) * erfc(x)
                  : 0.5641895835477563 / x * (1 - q * (0.5 - q * (0.75 - q * (1.875 - q * 6.5625))));
#else
    const float t = x < 1e30f ? (x - 2.0f) / (x + 2.0f) : 1.0f;
    /* Estrin's scheme has half as many steps in sequence as Horner's. */
    const float s = t * t, q = s * s;
    const float a = CML_FMA(-9.27630812e-2f, t, 1.27697837f), b = CML_FMA(1.64035842e-1f, t, -1.66031092e-1f);
    const float c = CML_FMA(-7.94272125e-3f, t, -5.42119592e-2f),
                d = CML_FMA(1.04314461e-3f, t, 8.68915953e-3f);
    const float e = CML_FMA(-1.8365443e-4f, t, -1.3957069e-3f);
    const float high = CML_FMA(CML_FMA(1.6080358e-4f, s, e), q, CML_FMA(d, s, c));
    const float p = CML_FMA(high, q, CML_FMA(b, s, a));
    return p / CML_FMA(2.0f, x, 1.0f);
#endif
}

/* Returns the x with erfc(x) = y, for 1e-7 < y < 2 - 1e-7. In float erfc(x) is y to 4e-7, and in the tail to
 * 1e-6 (1 + x^2) of y (unit.rough). Giles, Approximating the erfinv function, GPU Computing Gems Jade (2012);
 * in double with two more Newton steps. */
CML_ROUGH_FN real cml_erfc_inverse(real y)
{
    const real w = -cml_log(y * (2 - y));
    real p, q;
    if (w < 5) {
        q = w - (real)2.5;
        p = (real)2.81022636e-8;
        p = CML_FMA(p, q, (real)3.43273939e-7);
        p = CML_FMA(p, q, (real)-3.5233877e-6);
        p = CML_FMA(p, q, (real)-4.39150654e-6);
        p = CML_FMA(p, q, (real)2.1858087e-4);
        p = CML_FMA(p, q, (real)-1.25372503e-3);
        p = CML_FMA(p, q, (real)-4.17768164e-3);
        p = CML_FMA(p, q, (real)0.246640727);
        p = CML_FMA(p, q, (real)1.50140941);
    } else {
        q = CML_SQRT(w) - 3;
        p = (real)-2.00214257e-4;
        p = CML_FMA(p, q, (real)1.00950558e-4);
        p = CML_FMA(p, q, (real)1.34934322e-3);
        p = CML_FMA(p, q, (real)-3.67342844e-3);
        p = CML_FMA(p, q, (real)5.73950773e-3);
        p = CML_FMA(p, q, (real)-7.6224613e-3);
        p = CML_FMA(p, q, (real)9.43887047e-3);
        p = CML_FMA(p, q, (real)1.00167406);
        p = CML_FMA(p, q, (real)2.83297682);
    }
    real x = p * (1 - y);
#ifdef CML_DOUBLE
    for (int i = 0; i < 2; i++) x += (erfc(x) - y) * exp(x * x) * 0.8862269254527580;
#endif
    return x;
}

/* Returns -ln(1 - exp(-e)) for e > 0: the depth e of a facet as seen from the other side. Finite; relative
 * error < 5e-7 in float. */
CML_ROUGH_FN real cml_other_depth(real e)
{
#ifdef CML_DOUBLE
    return e < 0.69 ? fmin(-log(-expm1(-e)), 700) : -log1p(-exp(-e));
#else
    const float x = cml_exp_minus(e);
    if (x > 0.5f) {
        /* e / (1 - exp(-e)) = 1 + e / 2 + e^2 / 12 - e^4 / 720 + ..., with Bernoulli's numbers. */
        const float s = e * e;
        const float p = CML_FMA(s, CML_FMA(s, 3.3068783e-5f, -1.3888889e-3f), 8.3333333e-2f);
        const float share = e / CML_FMA(s, p, CML_FMA(e, 0.5f, 1.0f));
        return share > 1e-36f ? -cml_log(share) : 83.0f;
    }
    /* -ln(1 - x) = 2 artanh(x / (2 - x)), whose argument is at most 1/3. */
    const float y = x / (2 - x), s = y * y;
    float sum = 6.6666667e-2f;
    sum = CML_FMA(sum, s, 7.6923077e-2f);
    sum = CML_FMA(sum, s, 9.0909091e-2f);
    sum = CML_FMA(sum, s, 0.11111111f);
    sum = CML_FMA(sum, s, 0.14285714f);
    sum = CML_FMA(sum, s, 0.2f);
    sum = CML_FMA(sum, s, 0.33333333f);
    return 2 * CML_FMA(sum * s, y, y);
#endif
}

/* ---- Smith's shadowing ---- */

/* Returns Smith's Lambda, >= 0, of a direction with z > 0 (its size is used); infinite if the direction is
 * level. */
CML_ROUGH_FN real cml_rough_lambda(struct cml_rough rough, struct cml_vec v)
{
    const real across = rough.alpha * rough.alpha * CML_FMA(v.x, v.x, v.y * v.y), z = CML_FABS(v.z);
    if (rough.kind == CML_ROUGH_GGX) return (real)0.5 * across / (z * (z + CML_SQRT(CML_FMA(z, z, across))));
    const real t = CML_SQRT(across) / z;
    const real x = 1 / t, flat = (real)0.5641895835477563 * t; /* t / sqrt(pi) */
    const int level = !(t < (real)1e9), some = t > (real)0.05; /* below 0.05 the share is exp(-400) */
    const real above = flat - cml_erfcx(x), lambda = (real)0.5 * cml_exp_minus(x * x) * above;
    return level ? (real)0.5 * flat : ((some & (above > 0)) ? lambda : (real)0);
}

/* ---- the normals that a direction sees ---- */

/* Returns the direction -v as seen on the surface stretched to alpha 1, a unit vector. */
CML_ROUGH_FN struct cml_vec cml_rough_stretched(real alpha, struct cml_vec v)
{
    const struct cml_vec w = {-alpha * v.x, -alpha * v.y, -v.z};
    const real k = 1 / CML_SQRT(cml_dot(w, w));
    const struct cml_vec unit = {k * w.x, k * w.y, k * w.z};
    return unit;
}

/* Returns a number uniform in (0, 1), never 0 or 1, exact in float. */
CML_ROUGH_FN real cml_uniform_inside(cml_u32 word)
{
    return CML_FMA((real)(int)(word >> 9), (real)1.1920928955078125e-7, (real)5.9604644775390625e-8);
}

/* Returns a normal of ggx, not of unit length: a point of the unit sphere's cap about w, half-way to w. w:
 * direction from the stretched surface. Dupuy, Benyoub, Sampling visible GGX normals with spherical caps
 * (2023). Nothing cancels if w.z is near -1. */
CML_FN struct cml_vec cml_rough_normal_ggx(real alpha, struct cml_vec w, cml_u32 azimuth_word, cml_u32 word)
{
    real c, s;
    const real xi = cml_uniform_inside(word);
    const real cap = w.z < 0 ? CML_FMA(w.x, w.x, w.y * w.y) / (1 - w.z) : 1 + w.z;
    const real depth = xi * cap, sine = CML_SQRT(depth * (2 - depth));
    cml_circle_point(azimuth_word, &c, &s);
    const struct cml_vec h = {alpha * CML_FMA(sine, c, w.x), alpha * CML_FMA(sine, s, w.y), (1 - xi) * cap};
    return h;
}

/* Returns F(x), the integral from -infinity to x of (wz - t side) exp(-t^2): the slopes up to x that the
 * direction w sees. For x < 0 it returns F(x) exp(x^2). *density: side exp(-x^2) / F(x). */
CML_ROUGH_FN real cml_rough_share(real wz, real side, real x, real *density)
{
    const real tail = cml_erfcx(CML_FABS(x)), part = x < 0 ? (real)0.5 : (real)-0.5 * cml_exp_minus(x * x);
    const real whole = CML_FMA(part, tail, x < 0 ? (real)0 : (real)1);
    const real share = CML_FMA(wz * (real)1.7724538509055160, whole, CML_FABS(part) * side);
    const real kept = share > (real)1e-30 ? share : (real)1e-30;
    *density = 2 * CML_FABS(part) * side / kept;
    return kept;
}

/* A slope x below top = wz / side, and its distance y = top - x > 0 from the top. Each is kept with its own
 * digits. */
struct cml_rough_at {
    real x, y;
};

/* Returns a first guess of the slope with F(x) / F(top) = xi = exp(-v^2). F / F(top) is off by 0.02 at most.
 * Near the top, and for all top < 0.95, y is a rational function of v; k = sqrt(2 F(top) exp(top^2) / side)
 * makes its first two terms k v - 2 top (k v)^2 / 3 exact. Light from higher above sees slopes by the normal
 * law, with x = g, lowered by about 1 / (2 top - g). The constants were fitted to slopes found by
 * bisection. */
CML_ROUGH_FN struct cml_rough_at cml_rough_guess(real top, real k, real v, real xi)
{
    struct cml_rough_at at = {0, 0};
    if (top < 4) {
        const real flat = top < (real)0.95 ? CML_FMA(CML_FMA((real)0.1059, k, (real)0.8091), k, (real)-0.2005)
                                           : k * CML_FMA((real)-0.0716, top, (real)1.085);
        const real bent = flat - (real)0.66666667 * top * k;
        at.y = k * v * CML_FMA(bent, v, (real)1) / CML_FMA(flat, v, (real)1);
        at.x = top - at.y;
    }
    if (top > (real)0.95) {
        const real g = -cml_erfc_inverse(2 * xi);
        const real span = 2 * top + (real)0.4744 / top - g * CML_FMA((real)0.1217, g, (real)0.816);
        const real x = g - 1 / (span > (real)1.52 ? span : (real)1.52), y = top - x;
        at.x = y > at.y ? x : at.x;
        at.y = y > at.y ? y : at.y;
    }
    return at;
}

/* Returns a slope x of beckmann along w's azimuth, with the density (wz - x side)+ exp(-x^2). It takes one
 * step of Halley's method, in double two, for V = sqrt(-ln(F(x) / F(top))), which is almost straight. In
 * float F(x) / F(top) is xi to 1e-6 for light from less than 120 degrees, to 1e-5 up to 150 (unit.rough). */
CML_ROUGH_FN real cml_rough_slope(real wz, real side, real xi)
{
    real density = 2;
    const real top = wz / side, v = CML_SQRT(-cml_log(xi));
    const real all = top < 4 ? cml_rough_share(wz, side, top, &density) : wz * (real)1.7724538509055160;
    struct cml_rough_at at = cml_rough_guess(top, CML_SQRT(2 / density), v, xi);
    for (int i = 0; i < (sizeof(real) == 4 ? 1 : 2); i++) {
        const real share = cml_rough_share(wz, side, at.x, &density);
        const real lifted = top < 0 ? at.y * (at.y - 2 * top) : (at.x < 0 ? at.x * at.x : (real)0);
        const real gone = lifted - cml_log(share / all), least = 100 * CML_EPSILON * CML_EPSILON;
        const real V = CML_SQRT(gone > least ? gone : least), off = V * V * (V - v);
        const real slope = density * at.y * at.y;
        const real straight = slope * CML_FMA((real)-0.5, v, (real)1.5 * V),
                   bent = straight - off * CML_FMA(at.y, 2 * at.x, 1 + slope), lowest = (real)0.3 * slope * V;
        const real step = 2 * off * at.y / (bent > lowest ? bent : lowest);
        const real less = step < (real)0.8 * at.y ? step : (real)0.8 * at.y;
        at.x += less;
        at.y -= less;
    }
    return at.x;
}

/* Returns a normal of beckmann, not of unit length. w: direction from the stretched surface. */
CML_ROUGH_FN struct cml_vec cml_rough_normal_beckmann(real alpha, struct cml_vec w, cml_u32 along_word,
                                                      cml_u32 across_word)
{
    const real side = CML_SQRT(CML_FMA(w.x, w.x, w.y * w.y));
    const real y = -cml_erfc_inverse(2 * cml_uniform_inside(across_word)),
               xi = cml_uniform_inside(along_word);
    const int level = !(side > (real)1e-6);
    const real x = level ? -cml_erfc_inverse(2 * xi) : cml_rough_slope(w.z, side, xi);
    const real c = level ? (real)1 : w.x / side, s = level ? (real)0 : w.y / side;
    const struct cml_vec m = {-alpha * CML_FMA(c, x, -(s * y)), -alpha * CML_FMA(s, x, c * y), 1};
    return m;
}

/* Returns the unit normal of the facet that a packet in direction v meets. The facet is drawn from those
 * that are seen from -v. v may go up. */
CML_ROUGH_FN struct cml_vec cml_rough_normal(struct cml_rough rough, struct cml_vec v, cml_u32 first,
                                             cml_u32 second)
{
    const struct cml_vec w = cml_rough_stretched(rough.alpha, v);
    const struct cml_vec m = rough.kind == CML_ROUGH_GGX
                                 ? cml_rough_normal_ggx(rough.alpha, w, first, second)
                                 : cml_rough_normal_beckmann(rough.alpha, w, first, second);
    const real k = 1 / CML_SQRT(cml_dot(m, m));
    const struct cml_vec unit = {k * m.x, k * m.y, k * m.z};
    return unit;
}

/* ---- the walk ---- */

/* An orthonormal frame: z and two unit vectors across it, as in cml_deflect. */
struct cml_frame {
    struct cml_vec x, y, z;
};

/* Returns an orthonormal frame about the unit vector z. */
CML_ROUGH_FN struct cml_frame cml_frame_about(struct cml_vec z)
{
    const real sign = CML_COPYSIGN((real)1, z.z), k = -1 / cml_frame_divisor(z), both = z.x * z.y * k;
    const struct cml_frame frame = {{CML_FMA(sign * z.x * k, z.x, (real)1), sign * both, -sign * z.x},
                                    {both, CML_FMA(z.y * k, z.y, sign), -z.y},
                                    z};
    return frame;
}

/* Returns u in the coordinates of a frame. */
CML_ROUGH_FN struct cml_vec cml_in_frame(struct cml_frame frame, struct cml_vec u)
{
    const struct cml_vec v = {cml_dot(u, frame.x), cml_dot(u, frame.y), cml_dot(u, frame.z)};
    return v;
}

/* Returns v, given in the coordinates of a frame, in those of the scene. */
CML_ROUGH_FN struct cml_vec cml_from_frame(struct cml_frame frame, struct cml_vec v)
{
    const struct cml_vec none = {0, 0, 0};
    return cml_along(cml_along(cml_along(none, v.x, frame.x), v.y, frame.y), v.z, frame.z);
}

/* A packet on the rough surface, seen from the side that it is on: z points up, away from the surface. */
struct cml_rough_walk {
    struct cml_vec v; /* direction, unit */
    real e;           /* depth -ln u, where u is the share of the surface that lies lower */
    int beyond;       /* 1: on the other side of the boundary than at first */
    int steps;        /* number of facets that the packet has met */
};

/* Flies a walk in direction v to the next facet of a rough boundary (step 1 of P20). Returns 1 if the walk
 * leaves the boundary; otherwise *e becomes the depth of the facet. word: decides how far. */
CML_ROUGH_FN int cml_rough_fly(struct cml_rough rough, struct cml_vec v, real *e, cml_u32 word)
{
    const real flown = -cml_log(cml_uniform_inside(word)), lambda = cml_rough_lambda(rough, v), from = *e;
    const int leaves = (v.z > 0) & !(from * lambda > flown);
    const real next = from + flown / (v.z < 0 ? 1 + lambda : -lambda);
    *e = (leaves | (v.z == 0)) ? from : next;
    return leaves;
}

/* Turns a walk at a facet of a rough boundary with the unit normal m: reflection if the random word lies
 * below Fresnel's reflectance R, otherwise refraction, after which the walk goes on on the other side. n1:
 * index on the side of the walk; n2: index beyond. */
CML_ROUGH_FN struct cml_rough_walk cml_rough_turn(struct cml_rough_walk walk, struct cml_vec m, real n1,
                                                  real n2, cml_u32 word)
{
    const real cosine = -cml_dot(walk.v, m), ci = cosine < 0 ? (real)0 : (cosine > 1 ? (real)1 : cosine);
    real ct;
    const real R = cml_fresnel(n1, n2, ci, &ct);
    if (cml_uniform(word) <= R) {
        walk.v = cml_normalise(cml_along(walk.v, 2 * ci, m));
        return walk;
    }
    walk.v = cml_refract(walk.v, m, n1 / n2, ci, ct);
    walk.v.z = -walk.v.z;
    walk.e = cml_other_depth(walk.e);
    walk.beyond = !walk.beyond;
    return walk;
}

/* Reflects a walk at a facet of a rough backing, and returns the share of the weight that is reflected. */
CML_FN real cml_rough_mirror(struct cml_rough_walk *walk, struct cml_vec m, const struct cml_backing *backing)
{
    const real cosine = -cml_dot(walk->v, m), ci = cosine < 0 ? (real)0 : (cosine > 1 ? (real)1 : cosine);
    walk->v = cml_normalise(cml_along(walk->v, 2 * ci, m));
    if (backing->kind == CML_BACKING_METAL) return cml_metal_reflectance(backing->n, backing->k, ci);
    return backing->kept < 1 ? 1 - backing->kept : (real)0;
}

/* Returns the random words for facet number `step` that a packet meets in its boundary event `crossing`.
 * block_number: counts the blocks of random words that the packet has drawn at rough boundaries. The first
 * facet of the packet's first events takes its word from the lattice (P13). */
CML_FN struct cml_block cml_draw_rough(struct cml_stream stream, cml_u64 photon, cml_u32 crossing,
                                       cml_u32 block_number, int step)
{
    struct cml_block block = cml_draw(stream, photon, CML_PURPOSE_ROUGH, block_number);
    if (step == 0 && crossing < CML_LATTICE_REFLECTIONS && stream.lattice)
        block.w[3] = cml_lattice_draw(stream, photon, cml_lattice_reflection(crossing), block.w[3]);
    return block;
}

/* The end of a walk on facets: a packet that leaves the rough boundary. */
struct cml_rough_exit {
    struct cml_vec u; /* direction of the packet, unit */
    int transmitted;
    int steps;  /* number of facets met; CML_ROUGH_LIMIT: the packet is lost */
    real stays; /* backing: share of the weight that comes back, the product over all facets */
};

/* Walks a packet through a rough boundary (P20). u: direction of the packet; against: unit normal of the
 * boundary, towards the side from which it comes; n1: index there; n2: index beyond. *blocks: number of
 * random blocks that the packet has drawn at rough boundaries; it is counted on. backing: reflects at every
 * facet in place of n2; NULL: there is none. */
CML_FN struct cml_rough_exit cml_rough_event(struct cml_stream stream, cml_u64 photon, cml_u32 crossing,
                                             cml_u32 *blocks, struct cml_rough rough, struct cml_vec u,
                                             struct cml_vec against, real n1, real n2,
                                             const struct cml_backing *backing)
{
    const struct cml_frame frame = cml_frame_about(against);
    struct cml_rough_walk walk = {cml_in_frame(frame, u), 0, 0, 0};
    struct cml_rough_exit exit = {u, 0, 0, 1};
    struct cml_block draw = cml_draw_rough(stream, photon, crossing, (*blocks)++, 0);
    while (walk.steps < CML_ROUGH_LIMIT && !cml_rough_fly(rough, walk.v, &walk.e, draw.w[0])) {
        /* The next step needs this block for certain, so a processor draws it while it waits for the results
         * below. */
        const struct cml_block next = cml_draw_rough(stream, photon, crossing, (*blocks)++, ++walk.steps);
        const struct cml_vec m = cml_rough_normal(rough, walk.v, draw.w[1], draw.w[2]);
        if (backing)
            exit.stays *= cml_rough_mirror(&walk, m, backing);
        else
            walk = cml_rough_turn(walk, m, walk.beyond ? n2 : n1, walk.beyond ? n1 : n2, draw.w[3]);
        draw = next;
    }
    if (walk.beyond) walk.v.z = -walk.v.z;
    exit.u = cml_normalise(cml_from_frame(frame, walk.v));
    exit.transmitted = walk.beyond;
    exit.steps = walk.steps;
    return exit;
}
