/* The optics of one packet: free path, scattering, reflection, refraction. Pure functions without a branch
 * that a vector loop could not take as a select. Equations: Wang & Jacques, Monte Carlo Modeling of Light
 * Transport in Multi-layered Tissues (1992), chapter 3. SPDX-License-Identifier: MIT */
#ifndef CML_OPTICS_H
#define CML_OPTICS_H

#include "mathf.h"
#include "port.h"
#include "rng.h"

CML_FN real cml_dot(struct cml_vec a, struct cml_vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* a + s b */
CML_FN struct cml_vec cml_along(struct cml_vec a, real s, struct cml_vec b)
{
    const struct cml_vec v = {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
    return v;
}

/* One Newton step towards |u| = 1; enough once per event, because every event changes |u| by rounding only.
 */
CML_FN struct cml_vec cml_renormalise(struct cml_vec u)
{
    const real k = (real)1.5 - (real)0.5 * cml_dot(u, u);
    const struct cml_vec v = {k * u.x, k * u.y, k * u.z};
    return v;
}

/* Optical depth to the next interaction: -ln(u), exponential with mean 1 [eq. 3.9, dimensionless].
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

/* Henyey-Greenstein deflection [eq. 3.22]: cosine and sine of the polar angle.
 * s = 2 xi - 1 in (-1, 1), g in [-1, 1]. With d = 1 + g s
 *   1 - c = (1-g)^2 (1-s) (1+g + d) / (2 d^2),   1 + c = (1+g)^2 (1+s) (1-g + d) / (2 d^2):
 * products and sums of what is not negative, so nothing cancels at small angles or backwards, and g = 0 and
 * g = +-1 need no case of their own. The cosine comes from the smaller one and never leaves [-1, 1]. */
CML_FN void cml_henyey_greenstein(real g, real s, real *cosine, real *sine)
{
    const real below = (real)1 - g, above = (real)1 + g;
    const real d = g < 0 ? above - g * ((real)1 - s) : below + g * ((real)1 + s);
    const real k = (real)0.5 / (d * d);
    const real one_minus = k * below * below * ((real)1 - s) * (above + d);
    const real one_plus = k * above * above * ((real)1 + s) * (below + d);
    *cosine = one_minus < one_plus ? (real)1 - one_minus : one_plus - (real)1;
    *sine = CML_SQRT(one_minus * one_plus);
}

/* Turns the unit vector u by the polar angle (cosine ct, sine st) about the azimuth (cp, sp), renormalised.
 * Frame of [Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1) 2017]: no pole needs a case of
 * its own. */
CML_FN struct cml_vec cml_spin(struct cml_vec u, real ct, real st, real cp, real sp)
{
    const real sign = u.z < 0 ? (real)-1 : (real)1;
    const real a = (real)-1 / (sign + u.z);
    const real b = u.x * u.y * a;
    const real p = st * cp, q = st * sp;
    struct cml_vec v;
    v.x = p * ((real)1 + sign * u.x * u.x * a) + q * b + ct * u.x;
    v.y = p * (sign * b) + q * (sign + u.y * u.y * a) + ct * u.y;
    v.z = p * (-sign * u.x) - q * u.y + ct * u.z;
    return cml_renormalise(v);
}

/* Fresnel reflectance of unpolarised light [eqs 3.25-3.26] in cosine form: no angle is ever computed.
 * n1, n2 > 0  indices on the near, far side; ci cosine of incidence, 0..1
 * ct          out: cosine of transmission by Snell's law, 0 at total reflection
 * returns R, 0..1; exactly 1 at total reflection. Absolute error < 1e-6 in float, 1e-14 in double, plus what
 * a few roundings of ci do: that is more near the critical angle, where R has an infinite slope. */
CML_FN real cml_fresnel(real n1, real n2, real ci, real *ct)
{
    const real ratio = n1 / n2;
    const real square = (real)1 - ratio * ratio * ((real)1 - ci * ci);
    const int total = !(square > 0);
    const real c = CML_SQRT(total ? (real)0 : square);
    const real rs = (n1 * ci - n2 * c) / (n1 * ci + n2 * c);
    const real rp = (n1 * c - n2 * ci) / (n1 * c + n2 * ci);
    *ct = c;
    return total ? (real)1 : (real)0.5 * (rs * rs + rp * rp);
}

/* Mirror direction; normal is a unit vector, its sign is free. */
CML_FN struct cml_vec cml_reflect(struct cml_vec u, struct cml_vec normal)
{
    return cml_renormalise(cml_along(u, (real)-2 * cml_dot(u, normal), normal));
}

/* Refracted direction [Snell's law in vector form]: normal is a unit vector against u (dot(u, normal) = -ci),
 * ct from cml_fresnel, ratio = n1 / n2. */
CML_FN struct cml_vec cml_refract(struct cml_vec u, struct cml_vec normal, real ratio, real ci, real ct)
{
    const struct cml_vec scaled = {ratio * u.x, ratio * u.y, ratio * u.z};
    return cml_renormalise(cml_along(scaled, ratio * ci - ct, normal));
}

#endif
