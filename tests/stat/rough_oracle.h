/* Part of the independent program for rough boundaries: random numbers, vectors, and the walk on the
 * facets of a rough surface.
 *
 * Normals are drawn in other ways than in kernels/rough.h: the slope of a Beckmann facet by rejection, the
 * normal of a GGX facet by its lune on the sphere. Shares of height are kept as such.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <complex.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define PI 3.14159265358979323846
#define MOST_STEPS 1000 /* limit of facets met on one rough surface */

enum { SMOOTH, GGX, BECKMANN };
enum { CLEAR_BELOW, MIRROR, METAL };

struct vec {
    double x, y, z;
};
struct face {
    int kind;
    double alpha;
};
struct backing {
    int kind;
    double reflectance;
    double complex metal;
};

/* ---- random numbers: xoshiro256++ ---- */

static uint64_t state[4];

static inline uint64_t turned(uint64_t x, int by)
{
    return x << by | x >> (64 - by);
}

static inline double draw(void) /* uniform in (0, 1) */
{
    const uint64_t word = turned(state[0] + state[3], 23) + state[0], t = state[1] << 17;
    state[2] ^= state[0];
    state[3] ^= state[1];
    state[1] ^= state[2];
    state[0] ^= state[3];
    state[2] ^= t;
    state[3] = turned(state[3], 45);
    return ((double)(word >> 12) + 0.5) * 0x1p-52;
}

static inline void seed(uint64_t number)
{
    for (int i = 0; i < 4; i++) {
        uint64_t x = (number += 0x9e3779b97f4a7c15u);
        x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
        x = (x ^ x >> 27) * 0x94d049bb133111ebu;
        state[i] = x ^ x >> 31;
    }
}

/* ---- vectors ---- */

static inline double dot(struct vec a, struct vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct vec cross(struct vec a, struct vec b)
{
    return (struct vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline struct vec along(struct vec a, double t, struct vec b) /* Returns a + t b. */
{
    return (struct vec){a.x + t * b.x, a.y + t * b.y, a.z + t * b.z};
}

static inline struct vec scaled(struct vec a, double by)
{
    return (struct vec){a.x * by, a.y * by, a.z * by};
}

static inline struct vec unit(struct vec a)
{
    return scaled(a, 1 / sqrt(dot(a, a)));
}

static inline void frame(struct vec z, struct vec *x, struct vec *y)
{
    *x = unit(cross(z, fabs(z.x) < 0.7 ? (struct vec){1, 0, 0} : (struct vec){0, 1, 0}));
    *y = cross(z, *x);
}

static inline struct vec about(struct vec axis, double cosine, double azimuth)
{
    struct vec x, y;
    frame(axis, &x, &y);
    const double sine = sqrt(fmax(0, 1 - cosine * cosine));
    return unit(along(along(scaled(axis, cosine), sine * cos(azimuth), x), sine * sin(azimuth), y));
}

/* ---- optics of a facet ---- */

static inline double fresnel(double c, double n1, double n2, double *ct)
{
    const double q = n1 / n2, square = 1 - q * q * (1 - c * c);
    if (square <= 0) return 1;
    *ct = sqrt(square);
    const double s = (n1 * c - n2 * *ct) / (n1 * c + n2 * *ct), p = (n1 * *ct - n2 * c) / (n1 * *ct + n2 * c);
    return (s * s + p * p) / 2;
}

static inline double kept_back(const struct backing *backing, double c, double n)
{
    if (backing->kind == MIRROR) return backing->reflectance;
    const double complex square = backing->metal * backing->metal / (n * n),
                         inside = csqrt(square - (1 - c * c));
    const double s = cabs((c - inside) / (c + inside)),
                 p = cabs((square * c - inside) / (square * c + inside));
    return (s * s + p * p) / 2;
}

/* ---- the microsurface ---- */

static inline double lambda(struct face face, struct vec v)
{
    if (v.z < 0) return -1 - lambda(face, (struct vec){v.x, v.y, -v.z});
    const double t = face.alpha * hypot(v.x, v.y) / v.z;
    if (t == 0) return 0;
    if (face.kind == GGX) return t * t / (2 * (1 + hypot(1, t)));
    return fmax(0, (t * exp(-1 / (t * t)) / sqrt(PI) - erfc(1 / t)) / 2);
}

/* Draws x with the density (X - x)+ exp(-x^2), by rejection from a bound of that density. */
static inline double beckmann_slope(double X)
{
    for (;;) {
        if (X < -0.4) { /* x = X - s, and s exp(2 X s) is a sum of two exponential numbers */
            const double s = log(draw() * draw()) / (2 * X);
            if (draw() < exp(-s * s)) return X - s;
        } else {
            const double mean = fmax(X, 0), normal = mean * sqrt(PI);
            const bool narrow = draw() * (normal + 1) < normal;
            double x = sqrt(-log(draw()));
            if (narrow)
                x *= sin(2 * PI * draw());
            else if (X < 0 || draw() < 0.5)
                x = -x;
            if (draw() * (mean + fabs(x)) < X - x) return x;
        }
    }
}

/* Draws a normal with the density max(0, i.m) D(m). The azimuth of i in the stretched world is that of x. */
static inline struct vec seen_normal(struct face face, struct vec i)
{
    const struct vec w = unit((struct vec){face.alpha * i.x, face.alpha * i.y, i.z});
    const double sine = hypot(w.x, w.y), cosine = sine > 0 ? w.x / sine : 1, turn = sine > 0 ? w.y / sine : 0;
    struct vec h;
    if (face.kind == GGX) { /* a lune about y, from the horizon to the plane across w */
        const double a = 2 * PI * draw(), r = sqrt(draw()), y = r * cos(a), across = sqrt(1 - y * y);
        const double rest = draw() * (1 + w.z), s = 1 - rest, c = sqrt(rest * (2 - rest));
        h = (struct vec){across * (c * sine - s * w.z), y, across * (c * w.z + s * sine)};
    } else {
        const double y = sqrt(-log(draw())) * cos(2 * PI * draw());
        const double x = sine > 0 ? beckmann_slope(w.z / sine) : sqrt(-log(draw())) * cos(2 * PI * draw());
        h = (struct vec){-x, -y, 1};
    }
    return unit((struct vec){face.alpha * (cosine * h.x - turn * h.y),
                             face.alpha * (turn * h.x + cosine * h.y), h.z});
}

/* Walks on the facets of a rough surface; *v counts from the normal against the packet. Returns true if
 * the light passes (then z points the other way). *kept: share that a backing sends back; -1 after
 * MOST_STEPS facets. */
static inline bool walk(struct face face, double n1, double n2, const struct backing *backing, struct vec *v,
                        double *kept)
{
    double u = 1, ct = 0;
    bool beyond = false;
    *kept = 1;
    for (int step = 0; step < MOST_STEPS; step++) {
        const double shadow = lambda(face, *v);
        if (v->z > 0 && shadow == 0) return beyond;
        if (v->z != 0) u *= pow(draw(), -1 / shadow);
        if (v->z > 0 && u >= 1) return beyond;
        const struct vec m = seen_normal(face, scaled(*v, -1));
        const double c = -dot(*v, m), R = backing ? 1 : fresnel(c, n1, n2, &ct);
        if (backing) *kept *= kept_back(backing, c, n1);
        if (R >= 1 || draw() <= R) {
            *v = unit(along(*v, 2 * c, m));
            continue;
        }
        *v = unit(along(scaled(*v, n1 / n2), n1 / n2 * c - ct, m));
        v->z = -v->z;
        u = 1 - u;
        beyond = !beyond;
        const double other = n1;
        n1 = n2;
        n2 = other;
    }
    *kept = -1;
    return beyond;
}
