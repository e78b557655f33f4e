/* The optics of one packet: free path, scattering, reflection, refraction. Pure functions without a branch
 * that a vector loop could not take as a select. Equations: Wang & Jacques, Monte Carlo Modeling of Light
 * Transport in Multi-layered Tissues (1992, reprinted with corrections 1995), chapter 3.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "mathf.h"
#include "port.h"
#include "rng.h"
#include "types.h"

CML_FN real cml_dot(struct cml_vec a, struct cml_vec b)
{
    return CML_FMA(a.x, b.x, CML_FMA(a.y, b.y, a.z * b.z));
}

/* a + s b */
CML_FN struct cml_vec cml_along(struct cml_vec a, real s, struct cml_vec b)
{
    const struct cml_vec v = {CML_FMA(s, b.x, a.x), CML_FMA(s, b.y, a.y), CML_FMA(s, b.z, a.z)};
    return v;
}

/* One Newton step towards |u| = 1; enough once per event, because every event changes |u| by rounding only.
 */
CML_FN struct cml_vec cml_renormalise(struct cml_vec u)
{
    const real k = CML_FMA((real)-0.5, cml_dot(u, u), (real)1.5);
    const struct cml_vec v = {k * u.x, k * u.y, k * u.z};
    return v;
}

/* u / |u| of any length but 0. Within the reach of the Newton step it is cml_renormalise, bit for bit. */
CML_FN struct cml_vec cml_normalise(struct cml_vec u)
{
    const real square = cml_dot(u, u), off = square - 1;
    const real k = off * off < CML_EPSILON ? CML_FMA((real)-0.5, square, (real)1.5) : 1 / CML_SQRT(square);
    const struct cml_vec v = {k * u.x, k * u.y, k * u.z};
    return v;
}

/* P2: optical depth to the next interaction: -ln(u), exponential with mean 1 [eq. 3.9, dimensionless].
 * A word of 0 stands for all u < 2^-32: by the lack of memory its depth is 32 ln 2 plus a fresh draw, so the
 * tail has no end at 22 mean free paths. */
CML_FN real cml_optical_depth(struct cml_stream stream, cml_u64 photon, cml_u32 event, cml_u32 word)
{
    real tau = 0;
    for (cml_u32 redraw = 0; word == 0u; redraw++) {
        tau += (real)22.180709777918249;
        word = cml_draw(stream, photon, CML_PURPOSE_TAIL, event).w[redraw & 3u];
        if (redraw == 3u) break;
    }
    return tau - cml_log(cml_uniform(word));
}

/* cml_optical_depth but for a word of 0: infinite, to be drawn later. */
CML_FN real cml_depth_or_tail(cml_u32 word)
{
    const real depth = -cml_log(cml_uniform(word));
    return word ? depth : CML_INFINITY;
}

/* Two reciprocals for one division, each with up to three roundings; a b must not overflow. */
CML_FN void cml_reciprocals(real a, real b, real *per_a, real *per_b)
{
    const real q = (real)1 / (a * b);
    *per_a = q * b;
    *per_b = q * a;
}

/* Henyey-Greenstein deflection [eq. 3.22]: cosine c and sine of the polar angle. s = 2 xi - 1 in (-1, 1); g
 * in [-1, 1], where a negative one gives the mirror image of -g. With d = 1 + |g| s
 *   1 - c = (1-|g|)^2 (1-s) (1+|g| + d) / (2 d^2):
 * products and sums of what is not negative, so nothing cancels near the direction that is scattered to most,
 * and g = 0 and g = +-1 need no case of their own. d^2 comes from cml_deflection_square, its reciprocal from
 * the caller, who may have another one to take with it. */
CML_FN real cml_deflection_square(real g, real s)
{
    const real size = CML_FABS(g), d = CML_FMA(size, (real)1 + s, (real)1 - size);
    return d * d;
}

CML_FN real cml_one_minus_cosine(real g, real s, real per_square)
{
    const real size = CML_FABS(g), below = (real)1 - size, above = (real)1 + size;
    const real d = CML_FMA(size, (real)1 + s, below);
    const real part = ((real)0.5 * below) * below * ((real)1 - s) * (above + d) * per_square;
    return part < 2 ? part : (real)2;
}

/* one_minus: 1 - c, 0..2, of light that is mirrored where g is negative. */
CML_FN void cml_deflection(real g, real one_minus, real *cosine, real *sine)
{
    *cosine = CML_COPYSIGN((real)1, g) * ((real)1 - one_minus);
    *sine = CML_SQRT(one_minus * ((real)2 - one_minus));
}

CML_FN void cml_henyey_greenstein(real g, real s, real per_square, real *cosine, real *sine)
{
    cml_deflection(g, cml_one_minus_cosine(g, s, per_square), cosine, sine);
}

/* Whether a medium of this g has a table (struct cml_medium). */
CML_FN int cml_has_phase_table(real g)
{
    return CML_FABS(g) > 1;
}

/* The number that is drawn, in units of 2^-32, for a word: 0 straight on, so that a table of Henyey and
 * Greenstein's function deflects as that does. */
CML_FN cml_u32 cml_phase_draw(cml_u32 polar_word)
{
    return polar_word ^ 0x7fffffffu;
}

/* The cell of a word in the table of a medium; 0 where it has none. */
CML_FN cml_u32 cml_phase_cell_number(real g, cml_u32 polar_word)
{
    const real size = CML_FABS(g);
    const cml_u32 table = size > 1 ? (cml_u32)(int)size - 2u : 0u;
    const cml_u32 cell = cml_phase_draw(polar_word) >> (32 - CML_PHASE_LOG2_CELLS);
    return table * CML_PHASE_CELLS + (size > 1 ? cell : 0u);
}

/* The cell of a table that a polar word leads to: cell `number`, or, where that is divided, a part of it. */
CML_FN struct cml_phase_cell cml_phase_cell_at(CML_GLOBAL const struct cml_phase_cell *cells, cml_u32 number,
                                               cml_u32 polar_word)
{
    const struct cml_phase_cell cell = cells[number];
    const cml_u32 part = cml_phase_draw(polar_word) >> (32 - CML_PHASE_LOG2_CELLS - CML_PHASE_LOG2_PARTS) &
                         (CML_PHASE_PARTS - 1u);
    return cell.slope < 0 ? cells[(cml_u32)(int)-cell.start + part] : cell;
}

/* 1 - c of a word in its cell, 0..2. As for Henyey and Greenstein's function the lowest 8 bits have no part
 * in it, which round absorbed weight (P3). */
CML_FN real cml_phase_one_minus(struct cml_phase_cell cell, cml_u32 polar_word)
{
    const cml_u32 within = cml_phase_draw(polar_word) << CML_PHASE_LOG2_CELLS >> (CML_PHASE_LOG2_CELLS + 8);
    const real y = CML_FMA((real)(int)within, (real)6.103515625e-5, (real)3.0517578125e-5);
    return CML_FMA(cell.slope, y, cell.start);
}

/* The frame across a unit vector [Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1) 2017]: no
 * pole needs a case of its own. Needs the reciprocal of this, which lies in 1..2 but for its sign. */
CML_FN real cml_frame_divisor(struct cml_vec u)
{
    return CML_COPYSIGN((real)1, u.z) + u.z;
}

/* Turns the unit vector u by the polar angle (cosine ct, sine st) about the azimuth (cp, sp), renormalised.
 * per_divisor: 1 / cml_frame_divisor(u). */
CML_FN struct cml_vec cml_spin(struct cml_vec u, real per_divisor, real ct, real st, real cp, real sp)
{
    const real sign = CML_COPYSIGN((real)1, u.z), p = st * cp, q = st * sp;
    const real along = CML_FMA(p, u.x, q * u.y), k = CML_FMA(-along, per_divisor, ct);
    const struct cml_vec v = {CML_FMA(u.x, k, sign * p), CML_FMA(u.y, k, sign * q), CML_FMA(ct, u.z, -along)};
    return cml_renormalise(v);
}

/* P4: the direction after a scattering; words: of the interaction's block. */
CML_FN struct cml_vec cml_scatter(struct cml_vec u, real g, cml_u32 polar_word, cml_u32 azimuth_word)
{
    const real s = cml_uniform_symmetric(polar_word);
    real per_square, per_divisor, ct, st, cp, sp;
    cml_reciprocals(cml_deflection_square(g, s), cml_frame_divisor(u), &per_square, &per_divisor);
    cml_henyey_greenstein(g, s, per_square, &ct, &st);
    cml_circle_point(azimuth_word, &cp, &sp);
    return cml_spin(u, per_divisor, ct, st, cp, sp);
}

/* The direction after scattering (P4) in a medium with a table; drawn: cml_phase_one_minus. */
CML_FN struct cml_vec cml_scatter_drawn(struct cml_vec u, real g, real drawn, cml_u32 azimuth_word)
{
    real ct, st, cp, sp;
    cml_deflection(g, drawn, &ct, &st);
    cml_circle_point(azimuth_word, &cp, &sp);
    return cml_spin(u, (real)1 / cml_frame_divisor(u), ct, st, cp, sp);
}

/* The direction after scattering (P4) in any medium, for vector loops: both ways, of which it takes one.
 * drawn: anything in 0..2 where the medium has no table. */
CML_FN struct cml_vec cml_scatter_either(struct cml_vec u, real g, real drawn, cml_u32 polar_word,
                                         cml_u32 azimuth_word)
{
    const int has_table = cml_has_phase_table(g);
    const real s = cml_uniform_symmetric(polar_word), anisotropy = has_table ? (real)0 : g;
    real per_square, per_divisor, ct, st, cp, sp;
    cml_reciprocals(cml_deflection_square(anisotropy, s), cml_frame_divisor(u), &per_square, &per_divisor);
    const real by_law = cml_one_minus_cosine(anisotropy, s, per_square);
    cml_deflection(g, has_table ? drawn : by_law, &ct, &st);
    cml_circle_point(azimuth_word, &cp, &sp);
    return cml_spin(u, per_divisor, ct, st, cp, sp);
}

/* The direction after scattering (P4), with the tables of all media; NULL: there are none. */
CML_FN struct cml_vec cml_scatter_in(CML_GLOBAL const struct cml_phase_cell *cells, struct cml_vec u, real g,
                                     cml_u32 polar_word, cml_u32 azimuth_word)
{
    if (!CML_MAY_HAVE_PHASES || !cells) return cml_scatter(u, g, polar_word, azimuth_word);
    const struct cml_phase_cell cell =
        cml_phase_cell_at(cells, cml_phase_cell_number(g, polar_word), polar_word);
    return cml_scatter_either(u, g, cml_phase_one_minus(cell, polar_word), polar_word, azimuth_word);
}

/* P5: Fresnel reflectance of unpolarised light [eqs 3.25-3.26] in cosine form: no angle is ever computed.
 * n1, n2 > 0  indices on the near, far side; ci cosine of incidence, 0..1
 * ct          out: cosine of transmission by Snell's law, 0 at total reflection
 * returns R, 0..1; exactly 1 at total reflection. Absolute error < 1e-6 in float, 1e-14 in double, plus what
 * a few roundings of ci do: that is more near the critical angle, where R has an infinite slope. */
CML_FN real cml_fresnel(real n1, real n2, real ci, real *ct)
{
    const real ratio = n1 / n2;
    const real square = CML_FMA(ratio * ratio, CML_FMA(ci, ci, (real)-1), (real)1);
    const int total = !(square > 0);
    const real c = CML_SQRT(total ? (real)0 : square);
    const real s_sum = CML_FMA(n1, ci, n2 * c), p_sum = CML_FMA(n1, c, n2 * ci);
    const real a = CML_FMA(n1, ci, -(n2 * c)) * p_sum, b = CML_FMA(n1, c, -(n2 * ci)) * s_sum;
    const real sums = s_sum * p_sum, R = CML_FMA(a, a, b * b) / (2 * (sums * sums));
    *ct = c;
    return total ? (real)1 : R;
}

/* P12: the same of a medium with the index n + i k, relative to that of the near side [Born & Wolf,
 * Principles of Optics, section 14.2, with p^2 - q^2 = n^2 - k^2 - sin^2 and p q = n k]. Nothing cancels
 * where k is large. */
CML_FN real cml_metal_reflectance(real n, real k, real ci)
{
    const real c2 = ci * ci, s2 = 1 - c2, nk = n * k, d = CML_FMA(n, n, -(k * k)) - s2;
    const real size = CML_SQRT(CML_FMA(d, d, 4 * nk * nk)); /* p^2 + q^2 */
    const real p = CML_SQRT(d < 0 ? 2 * nk * nk / (size - d) : (real)0.5 * (size + d));
    const real s_mid = size + c2, s_two = 2 * p * ci, p_mid = CML_FMA(size, c2, s2 * s2), p_two = s_two * s2;
    const real Rs = (s_mid - s_two) / (s_mid + s_two), Rp = Rs * (p_mid - p_two) / (p_mid + p_two);
    const real R = (real)0.5 * (Rs + Rp);
    return ci > 0 ? (R > 0 ? R : (real)0) : (real)1;
}

/* Mirror direction; normal is a unit vector, its sign is free. */
CML_FN struct cml_vec cml_reflect(struct cml_vec u, struct cml_vec normal)
{
    return cml_renormalise(cml_along(u, (real)-2 * cml_dot(u, normal), normal));
}

/* Refracted direction [Snell's law in vector form]: normal is a unit vector against u (dot(u, normal) = -ci),
 * ct from cml_fresnel, ratio = n1 / n2. Its length is off by the rounding of ci times the square of the
 * ratio.
 */
CML_FN struct cml_vec cml_refract(struct cml_vec u, struct cml_vec normal, real ratio, real ci, real ct)
{
    const struct cml_vec scaled = {ratio * u.x, ratio * u.y, ratio * u.z};
    return cml_normalise(cml_along(scaled, ratio * ci - ct, normal));
}
