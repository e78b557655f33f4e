/* Exact signs of determinants. The filters and expansions are those of J. R. Shewchuk, "Adaptive precision
 * floating-point arithmetic and fast robust geometric predicates" (1997). SPDX-License-Identifier: MIT */
#include "geometry/predicate.h"

#include <float.h>
#include <math.h>

#define HALF_ULP (DBL_EPSILON / 2)

/* An exact number: the sum of doubles that do not overlap, rising in size. 192 parts suffice for the longest
 * sum in this file. */
struct exact {
    int n;
    double part[192];
};

/* Returns the sign of a number: 1, 0 or -1. */
static int sign_of(double x)
{
    return (x > 0.0) - (x < 0.0);
}

/* Returns a + b rounded, and the rounding error in *rest [D. E. Knuth, The art of computer programming 2,
 * 4.2.2]. */
static double two_sum(double a, double b, double *rest)
{
    const double sum = a + b;
    const double b_there = sum - a;
    *rest = (a - (sum - b_there)) + (b - b_there);
    return sum;
}

/* Returns a * b rounded, and the rounding error in *rest. fma rounds only once, so *rest is exact. */
static double two_product(double a, double b, double *rest)
{
    const double product = a * b;
    *rest = fma(a, b, -product);
    return product;
}

/* Adds a double to an exact number (Shewchuk's Grow-Expansion). The value passes all parts, the smallest
 * first, and leaves its rounding error at each. Zero parts are dropped, so that the last part has the sign of
 * the sum. */
static void exact_add(struct exact *x, double value)
{
    int n = 0;
    for (int i = 0; i < x->n; i++) {
        double rest;
        value = two_sum(value, x->part[i], &rest);
        if (rest != 0.0) x->part[n++] = rest;
    }
    if (value != 0.0) x->part[n++] = value;
    x->n = n;
}

/* Returns the sign of an exact number: that of its last part, which is the largest. */
static int exact_sign(const struct exact *x)
{
    return x->n == 0 ? 0 : sign_of(x->part[x->n - 1]);
}

/* The exact difference a - b as two doubles. */
struct difference {
    double part[2];
};

/* Returns the exact difference a - b. */
static struct difference subtract(double a, double b)
{
    struct difference d;
    d.part[0] = two_sum(a, -b, &d.part[1]);
    return d;
}

/* Adds sign * a * b exactly. Each difference is two doubles, so their product is four exact products. */
static void exact_add_product(struct exact *x, struct difference a, struct difference b, double sign)
{
    for (int i = 0; i < 4; i++) {
        double rest;
        const double product = two_product(sign * a.part[i & 1], b.part[i >> 1], &rest);
        if (product == 0.0) continue;
        exact_add(x, rest);
        exact_add(x, product);
    }
}

/* Adds product * factor to an exact number: the rounded result and its rounding error are both added. */
static void exact_add_scaled(struct exact *x, double product, double factor)
{
    double rest;
    const double scaled = two_product(product, factor, &rest);
    if (scaled == 0.0) return;
    exact_add(x, rest);
    exact_add(x, scaled);
}

/* Adds the product a b c of three differences exactly: eight products of three doubles. */
static void exact_add_triple(struct exact *x, struct difference a, struct difference b, struct difference c)
{
    for (int i = 0; i < 8; i++) {
        double rest;
        const double product = two_product(a.part[i & 1], b.part[(i >> 1) & 1], &rest);
        exact_add_scaled(x, rest, c.part[i >> 2]);
        exact_add_scaled(x, product, c.part[i >> 2]);
    }
}

/* Returns the exact negative of a difference. */
static struct difference negate(struct difference d)
{
    return (struct difference){{-d.part[0], -d.part[1]}};
}

/* Returns the sign of cml_orient2d's determinant from exact differences and products, for cases in which the
 * filter is unsure. */
static int orient2d_exact(const double a[2], const double b[2], const double c[2])
{
    struct exact det = {0};
    exact_add_product(&det, subtract(a[0], c[0]), subtract(b[1], c[1]), 1.0);
    exact_add_product(&det, subtract(a[1], c[1]), subtract(b[0], c[0]), -1.0);
    return exact_sign(&det);
}

/* Returns the sign of the rounded determinant. *sure is false if rounding may have changed the sign; the
 * bound is Shewchuk's ccwerrboundA. */
static int orient2d_filter(const double a[2], const double b[2], const double c[2], int *sure)
{
    const double left = (a[0] - c[0]) * (b[1] - c[1]);
    const double right = (a[1] - c[1]) * (b[0] - c[0]);
    const double det = left - right;
    const double bound = (3.0 + 16.0 * HALF_ULP) * HALF_ULP * (fabs(left) + fabs(right));
    *sure = fabs(det) > bound || bound == 0.0;
    return sign_of(det);
}

int cml_orient2d_fast(const double a[2], const double b[2], const double c[2])
{
    int sure;
    const int sign = orient2d_filter(a, b, c, &sure);
    return sure ? sign : 0;
}

int cml_orient2d(const double a[2], const double b[2], const double c[2])
{
    int sure;
    const int sign = orient2d_filter(a, b, c, &sure);
    return sure ? sign : orient2d_exact(a, b, c);
}

/* Returns the sign of cml_orient3d's determinant from exact differences and products. */
static int orient3d_exact(const double a[3], const double b[3], const double c[3], const double d[3])
{
    struct difference p[3][3];
    const double *const from[3] = {a, b, c};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) p[i][k] = subtract(from[i][k], d[k]);
    struct exact det = {0};
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        exact_add_triple(&det, p[j][0], p[k][1], p[i][2]);
        exact_add_triple(&det, negate(p[k][0]), p[j][1], p[i][2]);
    }
    return exact_sign(&det);
}

/* The filter's bound is Shewchuk's o3derrboundA; `size` is the sum of the terms' absolute values. A bound of
 * exactly 0 means that all products are exactly 0, as for points in a plane of the axes. */
int cml_orient3d(const double a[3], const double b[3], const double c[3], const double d[3])
{
    const double adx = a[0] - d[0], ady = a[1] - d[1], adz = a[2] - d[2];
    const double bdx = b[0] - d[0], bdy = b[1] - d[1], bdz = b[2] - d[2];
    const double cdx = c[0] - d[0], cdy = c[1] - d[1], cdz = c[2] - d[2];
    const double bc = bdx * cdy, cb = cdx * bdy;
    const double ca = cdx * ady, ac = adx * cdy;
    const double ab = adx * bdy, ba = bdx * ady;
    const double det = adz * (bc - cb) + bdz * (ca - ac) + cdz * (ab - ba);
    const double size = (fabs(bc) + fabs(cb)) * fabs(adz) + (fabs(ca) + fabs(ac)) * fabs(bdz) +
                        (fabs(ab) + fabs(ba)) * fabs(cdz);
    const double bound = (7.0 + 56.0 * HALF_ULP) * HALF_ULP * size;
    if (fabs(det) > bound || bound == 0.0) return sign_of(det);
    return orient3d_exact(a, b, c, d);
}

/* Returns on which side of the edge from a to b the line from o along u passes: the sign of a determinant,
 * computed exactly. The direction u needs no rounding. */
static int line_side_exact(const double a[3], const double b[3], const double o[3], const double u[3])
{
    struct exact det = {0};
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const struct difference along = {{u[i], 0.0}};
        exact_add_triple(&det, subtract(a[j], o[j]), subtract(b[k], o[k]), along);
        exact_add_triple(&det, negate(subtract(a[k], o[k])), subtract(b[j], o[j]), along);
    }
    return exact_sign(&det);
}

/* Returns the sign of the first non-zero component of (a - b) x u. It decides cml_line_side when the
 * determinant is 0 and the line is moved by (e, e^2, e^3). */
static int line_side_moved(const double a[3], const double b[3], const double u[3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const struct difference uj = {{u[j], 0.0}}, uk = {{u[k], 0.0}};
        struct exact part = {0};
        exact_add_product(&part, subtract(a[j], b[j]), uk, 1.0);
        exact_add_product(&part, subtract(a[k], b[k]), uj, -1.0);
        if (exact_sign(&part) != 0) return exact_sign(&part);
    }
    return 0;
}

/* The determinant has the form of cml_orient3d's with one difference fewer, because the direction u is exact,
 * so the same bound holds. */
int cml_line_side(const double a[3], const double b[3], const double o[3], const double u[3])
{
    const double ax = a[0] - o[0], ay = a[1] - o[1], az = a[2] - o[2];
    const double bx = b[0] - o[0], by = b[1] - o[1], bz = b[2] - o[2];
    const double yz = ay * bz, zy = az * by, zx = az * bx, xz = ax * bz, xy = ax * by, yx = ay * bx;
    const double det = u[0] * (yz - zy) + u[1] * (zx - xz) + u[2] * (xy - yx);
    const double size = (fabs(yz) + fabs(zy)) * fabs(u[0]) + (fabs(zx) + fabs(xz)) * fabs(u[1]) +
                        (fabs(xy) + fabs(yx)) * fabs(u[2]);
    if (fabs(det) > (7.0 + 56.0 * HALF_ULP) * HALF_ULP * size) return sign_of(det);
    const int sign = line_side_exact(a, b, o, u);
    return sign != 0 ? sign : line_side_moved(a, b, u);
}

/* A point in the plane counts as moved by (e, e^2, e^3), so the first non-zero coordinate of the triangle's
 * normal decides [the idea is that of H. Edelsbrunner and E. P. Muecke, Simulation of simplicity, ACM Trans.
 * Graphics 9 (1990) 66]. These coordinates are areas of the triangle's projections. */
int cml_plane_side(const double a[3], const double b[3], const double c[3], const double o[3])
{
    int sign = cml_orient3d(a, b, c, o);
    for (int i = 0; i < 3 && sign == 0; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double p[2] = {a[j], a[k]}, q[2] = {b[j], b[k]}, r[2] = {c[j], c[k]};
        sign = -cml_orient2d(p, q, r);
    }
    return sign;
}
