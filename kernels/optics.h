/* The optics of one packet: free path, scattering, reflection, refraction. All are pure functions without
 * branches that a vector loop could not take. Equations: Wang & Jacques, Monte Carlo Modeling of Light
 * Transport in Multi-layered Tissues (1992, reprinted with corrections 1995), chapter 3.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "mathf.h"
#include "port.h"
#include "rng.h"
#include "types.h"

/* Returns the scalar product of two vectors. */
CML_FN real cml_dot(struct cml_vec a, struct cml_vec b)
{
    return CML_FMA(a.x, b.x, CML_FMA(a.y, b.y, a.z * b.z));
}

/* Returns a + s b. */
CML_FN struct cml_vec cml_along(struct cml_vec a, real s, struct cml_vec b)
{
    const struct cml_vec v = {CML_FMA(s, b.x, a.x), CML_FMA(s, b.y, a.y), CML_FMA(s, b.z, a.z)};
    return v;
}

/* Returns u after one Newton step towards |u| = 1. One step per event is enough, because every event changes
 * |u| by rounding only. */
CML_FN struct cml_vec cml_renormalise(struct cml_vec u)
{
    const real k = CML_FMA((real)-0.5, cml_dot(u, u), (real)1.5);
    const struct cml_vec v = {k * u.x, k * u.y, k * u.z};
    return v;
}

/* Returns u / |u| for u of any length but 0. For a length close to 1 it equals cml_renormalise, bit for
 * bit. */
CML_FN struct cml_vec cml_normalise(struct cml_vec u)
{
    const real square = cml_dot(u, u), off = square - 1;
    const real k = off * off < CML_EPSILON ? CML_FMA((real)-0.5, square, (real)1.5) : 1 / CML_SQRT(square);
    const struct cml_vec v = {k * u.x, k * u.y, k * u.z};
    return v;
}

/* Returns the optical depth to the next interaction (P2): -ln(u), exponential with mean 1 [eq. 3.9,
 * dimensionless]. A word of 0 stands for all u < 2^-32. Since an exponential depth has no memory, its depth
 * is 32 ln 2 plus that of a fresh word; without this the tail would end at 23 mean free paths. */
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

/* Returns cml_optical_depth, or infinity for a word of 0, whose depth is drawn later. */
CML_FN real cml_depth_or_tail(cml_u32 word)
{
    const real depth = -cml_log(cml_uniform(word));
    return word ? depth : CML_INFINITY;
}

/* Finds 1 / a and 1 / b with one division; each has up to three roundings. a b must not overflow. */
CML_FN void cml_reciprocals(real a, real b, real *per_a, real *per_b)
{
    const real q = (real)1 / (a * b);
    *per_a = q * b;
    *per_b = q * a;
}

/* Returns the square d^2 in Henyey and Greenstein's formula [eq. 3.22], with d = 1 + |g| s, s = 2 xi - 1 in
 * (-1, 1), g in [-1, 1]:
 *   1 - c = (1-|g|)^2 (1-s) (1+|g| + d) / (2 d^2),   c: cosine of the polar angle; a negative g mirrors it
 * All factors are products and sums of numbers >= 0, so nothing cancels near the direction of most light, and
 * g = 0 and g = +-1 are no special cases. The square is a function of its own, because a caller may take its
 * reciprocal together with another one (cml_reciprocals). */
CML_FN real cml_deflection_square(real g, real s)
{
    const real size = CML_FABS(g), d = CML_FMA(size, (real)1 + s, (real)1 - size);
    return d * d;
}

/* Returns 1 - c, 0..2, by Henyey and Greenstein's formula. per_square: 1 / cml_deflection_square(g, s). */
CML_FN real cml_one_minus_cosine(real g, real s, real per_square)
{
    const real size = CML_FABS(g), below = (real)1 - size, above = (real)1 + size;
    const real d = CML_FMA(size, (real)1 + s, below);
    const real part = ((real)0.5 * below) * below * ((real)1 - s) * (above + d) * per_square;
    return part < 2 ? part : (real)2;
}

/* Finds the cosine and sine of the polar angle. one_minus: 1 - cosine, 0..2, of the unmirrored function; a
 * negative g mirrors it. */
CML_FN void cml_deflection(real g, real one_minus, real *cosine, real *sine)
{
    *cosine = CML_COPYSIGN((real)1, g) * ((real)1 - one_minus);
    *sine = CML_SQRT(one_minus * ((real)2 - one_minus));
}

/* Finds cosine and sine of the polar angle by Henyey and Greenstein's function. per_square: 1 /
 * cml_deflection_square(g, s). */
CML_FN void cml_henyey_greenstein(real g, real s, real per_square, real *cosine, real *sine)
{
    cml_deflection(g, cml_one_minus_cosine(g, s, per_square), cosine, sine);
}

/* True if a medium of this g has a phase table (struct cml_medium). */
CML_FN int cml_has_phase_table(real g)
{
    return CML_FABS(g) > 1;
}

/* Returns the number v of a phase table for a word, in units of 2^-32. v = 0 means straight on. v falls as
 * the signed word rises, so a table of Henyey and Greenstein's function deflects as the closed form does. */
CML_FN cml_u32 cml_phase_draw(cml_u32 polar_word)
{
    return polar_word ^ 0x7fffffffu;
}

/* Returns the number of a word's cell in the table of a medium with this g; 0 if the medium has no table. */
CML_FN cml_u32 cml_phase_cell_number(real g, cml_u32 polar_word)
{
    const real size = CML_FABS(g);
    const cml_u32 table = size > 1 ? (cml_u32)(int)size - 2u : 0u;
    const cml_u32 cell = cml_phase_draw(polar_word) >> (32 - CML_PHASE_LOG2_CELLS);
    return table * CML_PHASE_CELLS + (size > 1 ? cell : 0u);
}

/* Returns the table's cell for the random word of a polar angle. Cell `number` may be divided into parts;
 * then the part for the word is returned. */
CML_FN struct cml_phase_cell cml_phase_cell_at(CML_GLOBAL const struct cml_phase_cell *cells, cml_u32 number,
                                               cml_u32 polar_word)
{
    const struct cml_phase_cell cell = cells[number];
    const cml_u32 part = cml_phase_draw(polar_word) >> (32 - CML_PHASE_LOG2_CELLS - CML_PHASE_LOG2_PARTS) &
                         (CML_PHASE_PARTS - 1u);
    return cell.slope < 0 ? cells[(cml_u32)(int)-cell.start + part] : cell;
}

/* Returns 1 - c, 0..2, of a word in its cell. The lowest 8 bits of the word are not used, because they round
 * absorbed weight (P3). */
CML_FN real cml_phase_one_minus(struct cml_phase_cell cell, cml_u32 polar_word)
{
    const cml_u32 within = cml_phase_draw(polar_word) << CML_PHASE_LOG2_CELLS >> (CML_PHASE_LOG2_CELLS + 8);
    const real y = CML_FMA((real)(int)within, (real)6.103515625e-5, (real)3.0517578125e-5);
    return CML_FMA(cell.slope, y, cell.start);
}

/* Returns the number whose reciprocal cml_deflect needs to build a frame across u; its size lies in 1..2.
 * This frame has no pole [Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1) 2017]. */
CML_FN real cml_frame_divisor(struct cml_vec u)
{
    return CML_COPYSIGN((real)1, u.z) + u.z;
}

/* Returns the unit vector u turned by the polar angle (cosine ct, sine st) about the azimuth (cp, sp),
 * renormalised. per_divisor: 1 / cml_frame_divisor(u). */
CML_FN struct cml_vec cml_deflect(struct cml_vec u, real per_divisor, real ct, real st, real cp, real sp)
{
    const real sign = CML_COPYSIGN((real)1, u.z), p = st * cp, q = st * sp;
    const real along = CML_FMA(p, u.x, q * u.y), k = CML_FMA(-along, per_divisor, ct);
    const struct cml_vec v = {CML_FMA(u.x, k, sign * p), CML_FMA(u.y, k, sign * q), CML_FMA(ct, u.z, -along)};
    return cml_renormalise(v);
}

/* Returns the direction after a scattering by Henyey and Greenstein's function (P4). The words are those of
 * the interaction's block. */
CML_FN struct cml_vec cml_scatter(struct cml_vec u, real g, cml_u32 polar_word, cml_u32 azimuth_word)
{
    const real s = cml_uniform_symmetric(polar_word);
    real per_square, per_divisor, ct, st, cp, sp;
    cml_reciprocals(cml_deflection_square(g, s), cml_frame_divisor(u), &per_square, &per_divisor);
    cml_henyey_greenstein(g, s, per_square, &ct, &st);
    cml_circle_point(azimuth_word, &cp, &sp);
    return cml_deflect(u, per_divisor, ct, st, cp, sp);
}

/* Returns the direction after a scattering (P4) in a medium with a phase table. drawn: result of
 * cml_phase_one_minus. */
CML_FN struct cml_vec cml_scatter_drawn(struct cml_vec u, real g, real drawn, cml_u32 azimuth_word)
{
    real ct, st, cp, sp;
    cml_deflection(g, drawn, &ct, &st);
    cml_circle_point(azimuth_word, &cp, &sp);
    return cml_deflect(u, (real)1 / cml_frame_divisor(u), ct, st, cp, sp);
}

/* Returns the direction after a scattering (P4) in any medium, for vector loops: it computes both ways and
 * takes one. drawn: any number in 0..2 if the medium has no table. */
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
    return cml_deflect(u, per_divisor, ct, st, cp, sp);
}

/* Returns the direction after a scattering (P4) in any medium. cells: the tables of all media; NULL: there
 * are none. */
CML_FN struct cml_vec cml_scatter_in(CML_GLOBAL const struct cml_phase_cell *cells, struct cml_vec u, real g,
                                     cml_u32 polar_word, cml_u32 azimuth_word)
{
    if (!CML_MAY_HAVE_PHASES || !cells) return cml_scatter(u, g, polar_word, azimuth_word);
    const struct cml_phase_cell cell =
        cml_phase_cell_at(cells, cml_phase_cell_number(g, polar_word), polar_word);
    return cml_scatter_either(u, g, cml_phase_one_minus(cell, polar_word), polar_word, azimuth_word);
}

/* Returns Fresnel's reflectance R of unpolarised light, 0..1, exactly 1 at total reflection (P5) [eqs
 * 3.25-3.26]. The formula is in cosines: no angle is computed. n1, n2 > 0: indices on the near and far side;
 * ci: cosine of incidence, 0..1; *ct: cosine of transmission by Snell's law, 0 at total reflection. Absolute
 * error < 1e-6 in float, 1e-14 in double, plus the effect of a few roundings of ci. This effect is larger
 * near the critical angle, where R has an infinite slope. */
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

/* Returns the reflectance of a metal with the index n + i k, relative to that of the near side (P12), for the
 * cosine of incidence ci, 0..1 [Born & Wolf, Principles of Optics, section 14.2, with p^2 - q^2 = n^2 - k^2 -
 * sin^2 and p q = n k]. Nothing cancels if k is large. */
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

/* Returns the absorbed part of the weight (P3): w * absorb rounded up or down at random, so that the mean is
 * kept. 16 random bits serve: 8 of the polar word that the cosine does not use, and 8 of the azimuth word.
 * For the smallest share that the input allows, 1e-11 of a whole packet (CML_LEAST_ABSORPTION), the mean is
 * off by at most 2^-17 / (1e-11 * 2^31) = 4e-4 of it. */
CML_FN cml_u32 cml_absorbed_part(cml_u32 w, real absorb, cml_u32 polar_word, cml_u32 azimuth_word)
{
    const cml_u32 bits = (azimuth_word & 255u) << 8 | (polar_word & 255u);
    const real lot = CML_FMA((real)bits, (real)1.52587890625e-5, (real)7.62939453125e-6);
    const cml_u32 part = (cml_u32)CML_FMA((real)w, absorb, lot);
    return part < w ? part : w;
}

/* Returns the cosine of incidence, 0..1, of the direction u on a surface with the unit normal `against` u. */
CML_FN real cml_incidence(struct cml_vec u, struct cml_vec against)
{
    const real cosine = -cml_dot(u, against);
    return cosine < 0 ? (real)0 : (cosine > 1 ? (real)1 : cosine);
}

/* Returns the direction of u after a mirror. normal: a unit vector of either sign. */
CML_FN struct cml_vec cml_reflect(struct cml_vec u, struct cml_vec normal)
{
    return cml_renormalise(cml_along(u, (real)-2 * cml_dot(u, normal), normal));
}

/* Returns the refracted direction by Snell's law in vector form. normal: a unit vector against u (dot(u,
 * normal) = -ci); ct: from cml_fresnel; ratio: n1 / n2. Before it is normalised, its length is off by the
 * rounding of ci times the square of the ratio. */
CML_FN struct cml_vec cml_refract(struct cml_vec u, struct cml_vec normal, real ratio, real ci, real ct)
{
    const struct cml_vec scaled = {ratio * u.x, ratio * u.y, ratio * u.z};
    return cml_normalise(cml_along(scaled, ratio * ci - ct, normal));
}
