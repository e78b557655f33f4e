/* A radial heightfield, and an oracle for the first crossing of a ray with it: in long double, and without
 * solving a quadratic.
 *
 * The ray is cut at the cylinders of the rings. In each span the height above the surface is convex or
 * concave, so that its least value lies at an end, or at the one point where its slope is zero. The first
 * crossing is then found by bisection.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "cone.h"
#include "lib/dice.h"

#define MAX_RINGS 64

struct field {
    real r[MAX_RINGS], z[MAX_RINGS], slope[MAX_RINGS], parts_per_cm;
    int n, start[MAX_RINGS];
    double steepest, deepest; /* largest |slope|, and largest |z| */
};

static inline struct cml_rings rings_of(const struct field *field)
{
    const struct cml_rings rings = {field->r, field->z, field->slope, field->start, field->parts_per_cm,
                                    field->n};
    return rings;
}

/* Computes slopes and parts from the samples, as the engines do. */
static inline void field_finish(struct field *field)
{
    field->parts_per_cm = cml_ring_starts(field->r, field->n, field->start);
    field->steepest = field->deepest = 0;
    for (int i = 0; i < field->n; i++) {
        const double dz = i + 1 < field->n ? (double)field->z[i + 1] - (double)field->z[i] : 0;
        field->slope[i] = (real)(i + 1 < field->n ? dz / ((double)field->r[i + 1] - (double)field->r[i]) : 0);
        field->steepest = fmax(field->steepest, fabs((double)field->slope[i]));
        field->deepest = fmax(field->deepest, fabs((double)field->z[i]));
    }
}

static inline struct field field_of(int n, const double *r, const double *z)
{
    struct field field = {.n = n};
    for (int i = 0; i < n; i++) {
        field.r[i] = (real)r[i];
        field.z[i] = (real)z[i];
    }
    field_finish(&field);
    return field;
}

/* Returns a random field: 3 to 60 rings, spacings over two decades, slopes up to `steep`, some rings flat. */
static inline struct field field_random(struct dice *dice, double steep)
{
    struct field field = {.n = 3 + dice_below(dice, 58)};
    double r = 0, z = dice_between(dice, -1, 1);
    for (int i = 0; i < field.n; i++) {
        field.r[i] = (real)r;
        field.z[i] = (real)z;
        const double width = exp(dice_between(dice, log(0.01), 0));
        const int kind = dice_below(dice, 8);
        if (kind > 1) z += width * dice_between(dice, -steep, steep) * (kind > 4 ? 0.05 : 1);
        r += width;
    }
    field_finish(&field);
    return field;
}

static inline int field_ring(const struct field *field, long double r)
{
    int i = 0;
    while (i + 1 < field->n && r >= (long double)field->r[i + 1]) i++;
    return i;
}

static inline long double field_depth(const struct field *field, long double r)
{
    const int i = field_ring(field, r);
    if (i + 1 == field->n) return field->z[i];
    const long double r0 = field->r[i], r1 = field->r[i + 1], z0 = field->z[i], z1 = field->z[i + 1];
    return z0 + (z1 - z0) * ((r - r0) / (r1 - r0));
}

struct ray {
    long double p[3], u[3], a, b, c, k; /* names as in struct cml_cone_ray */
    double side;
};

static inline struct ray ray_of(struct cml_vec p, struct cml_vec u, double side)
{
    struct ray ray = {{p.x, p.y, p.z}, {u.x, u.y, u.z}, 0, 0, 0, 0, side};
    ray.a = ray.u[0] * ray.u[0] + ray.u[1] * ray.u[1];
    ray.b = ray.p[0] * ray.u[0] + ray.p[1] * ray.u[1];
    ray.c = ray.p[0] * ray.p[0] + ray.p[1] * ray.p[1];
    ray.k = ray.p[0] * ray.u[1] - ray.p[1] * ray.u[0];
    return ray;
}

static inline long double ray_radius(const struct ray *ray, long double t)
{
    return hypotl(ray->p[0] + t * ray->u[0], ray->p[1] + t * ray->u[1]);
}

/* Returns the height of the ray above the surface, positive on the packet's own side. */
static inline long double ray_height(const struct field *field, const struct ray *ray, long double t)
{
    return ray->side * (ray->p[2] + t * ray->u[2] - field_depth(field, ray_radius(ray, t)));
}

static inline int compare_times(const void *a, const void *b)
{
    const long double x = *(const long double *)a, y = *(const long double *)b;
    return (x > y) - (x < y);
}

/* Writes the ends of the spans in [0, t_max], and the point of zero slope in each span that has one. Returns
 * their number. */
static inline int ray_stations(const struct field *field, const struct ray *ray, long double t_max,
                               long double station[])
{
    int n = 0;
    station[n++] = 0;
    station[n++] = t_max;
    if (!(ray->a > 0)) return n;
    for (int i = 0; i < field->n; i++) {
        const long double ri = field->r[i], square = ray->a * ri * ri - ray->k * ray->k;
        const long double root = sqrtl(fmaxl(square, 0));
        station[n++] = (-ray->b - root) / ray->a;
        station[n++] = (-ray->b + root) / ray->a;
        /* zero slope: m r'(t) = uz, where a r^2 = s^2 + k^2 and r' = s / r with s = b + a t */
        const long double q = field->slope[i] != 0 ? ray->u[2] / (long double)field->slope[i] : 0;
        if (q * q >= ray->a) continue;
        station[n++] = (q * fabsl(ray->k) / sqrtl(ray->a - q * q) - ray->b) / ray->a;
    }
    int kept = 0;
    for (int i = 0; i < n; i++)
        if (station[i] >= 0 && station[i] <= t_max) station[kept++] = station[i];
    qsort(station, (size_t)kept, sizeof *station, compare_times);
    return kept;
}

/* Returns the first t in [0, t_max] at which the ray is below the level on its own side, or INFINITY. t_max
 * must be finite. */
static inline long double ray_first_below(const struct field *field, const struct ray *ray, long double level,
                                          const long double station[], int n)
{
    for (int i = 0; i < n; i++) {
        if (!(ray_height(field, ray, station[i]) < level)) continue;
        if (i == 0) return station[0];
        long double low = station[i - 1], high = station[i];
        for (int step = 0; step < 90 && high > low; step++) {
            const long double middle = 0.5L * (low + high);
            if (ray_height(field, ray, middle) < level)
                high = middle;
            else
                low = middle;
        }
        return high;
    }
    return INFINITY;
}

/* Returns a distance beyond which the ray stays over the outer plane, and is either far above it or far
 * below it. */
static inline double ray_end(const struct field *field, const struct ray *ray, double t_max)
{
    const double size =
        (double)field->r[field->n - 1] + (double)sqrtl(ray->c) + fabs((double)ray->p[2]) + field->deepest;
    double end = 4 * size;
    if (ray->a > 0) end = fmax(end, 4 * size / sqrt((double)ray->a));
    if (ray->u[2] != 0) end = fmax(end, 4 * size / fabs((double)ray->u[2]));
    return fmin(end, t_max);
}

/* Returns a bound of the rounding error of a height at distance t. */
static inline double ray_rounding(const struct field *field, const struct ray *ray, double t)
{
    const double size = (double)sqrtl(ray->c) + fabs((double)ray->p[2]) + field->deepest + t;
    return (double)CML_EPSILON * (1 + field->steepest) * size;
}
