/* Cuts convex polygons into the fan of triangles whose smallest triangle is the largest.
 *
 *     d-------c        A fan has its apex in one corner, and n - 2 triangles. With
 *     |      /|        corners a, b, e on a straight side, apex a makes the triangle
 *     |    /  |        a b e of no area; apex d does not.
 *     a--b----e
 *
 * SPDX-License-Identifier: MIT */
#include "input/mesh/obj_polygon.h"

#include "geometry/vec3.h"

#include <math.h>
#include <stdbool.h>

struct polygon {
    const double (*vertex)[3];
    const uint32_t *corner;
    size_t size;
    double normal[3]; /* unit vector */
    double extent;    /* largest difference of a coordinate to the first corner */
    double center[3]; /* mean of the corners */
};

/* Returns the vertex of corner i; corners are counted round the polygon. */
static const double *point(const struct polygon *p, size_t i)
{
    return p->vertex[p->corner[i % p->size]];
}

/* Returns the area of a triangle, seen along the polygon's normal; negative where the corner turns inwards.
 */
static double signed_area(const struct polygon *p, size_t a, size_t b, size_t c)
{
    double area[3];
    cml_vec3_area(point(p, a), point(p, b), point(p, c), area);
    return cml_vec3_dot(area, p->normal);
}

/* Finds normal, mean and extent. The normal is that of the sum of the areas of all triangles of a fan
 * [Newell's method], so no corner needs to be convex. False: the polygon has no area. */
static bool find_plane(struct polygon *p)
{
    for (size_t i = 1; i + 1 < p->size; i++) {
        double area[3];
        cml_vec3_area(point(p, 0), point(p, i), point(p, i + 1), area);
        for (int k = 0; k < 3; k++) p->normal[k] += area[k];
    }
    for (size_t i = 0; i < p->size; i++)
        for (int k = 0; k < 3; k++) {
            p->extent = fmax(p->extent, fabs(point(p, i)[k] - point(p, 0)[k]));
            p->center[k] += point(p, i)[k] / (double)p->size;
        }
    const double length = hypot(hypot(p->normal[0], p->normal[1]), p->normal[2]);
    if (!(length > 0) || !isfinite(length)) return false;
    for (int k = 0; k < 3; k++) p->normal[k] /= length;
    return true;
}

/* Returns the largest distance of a corner from the mean plane of the polygon; 0 if it is so small that
 * rounded decimals in the file may cause it. */
static double bend_of(const struct polygon *p)
{
    double bend = 0;
    for (size_t i = 0; i < p->size; i++) {
        double height = 0;
        for (int k = 0; k < 3; k++) height += (point(p, i)[k] - p->center[k]) * p->normal[k];
        bend = fmax(bend, fabs(height));
    }
    return bend > 1e-9 * p->extent ? bend : 0;
}

/* True if the polygon is convex, seen along its normal: no corner turns right, and all turns together make
 * one full turn (those of a star make two). */
static bool is_convex(const struct polygon *p)
{
    double turned = 0;
    for (size_t i = 0; i < p->size; i++) {
        const double sine = signed_area(p, i, i + 1, i + 2);
        double cosine = 0;
        for (int k = 0; k < 3; k++)
            cosine += (point(p, i + 1)[k] - point(p, i)[k]) * (point(p, i + 2)[k] - point(p, i + 1)[k]);
        if (sine < -1e-12 * p->extent * p->extent) return false;
        turned += atan2(sine, cosine);
    }
    return fabs(turned) < 9; /* one turn is 2 pi, two are 4 pi */
}

/* Returns the area of the smallest triangle of the fan about an apex. It is 0 for some apexes if corners lie
 * on a straight side. */
static double smallest_triangle(const struct polygon *p, size_t apex)
{
    double smallest = INFINITY;
    for (size_t i = 1; i + 1 < p->size; i++)
        smallest = fmin(smallest, signed_area(p, apex, apex + i, apex + i + 1));
    return smallest;
}

/* Splits a convex polygon into triangles that share one corner: the corner whose smallest triangle is
 * largest, which avoids needles. Returns NULL, or what is wrong with the polygon. *bend: how far corners lie
 * off the mean plane. */
const char *cml_obj_split(const double (*vertex)[3], const uint32_t *corner, size_t size,
                          uint32_t (*triangle)[3], double *bend)
{
    struct polygon p = {.vertex = vertex, .corner = corner, .size = size};
    if (!find_plane(&p)) return "has no area";
    if (!is_convex(&p)) return "is not convex";
    size_t apex = 0;
    double largest = 0;
    for (size_t i = 0; i < size; i++) {
        const double smallest = smallest_triangle(&p, i);
        if (!(smallest > largest)) continue;
        largest = smallest;
        apex = i;
    }
    if (!(largest > 0)) return "cannot be split into triangles that meet in one corner";
    *bend = bend_of(&p);
    for (size_t i = 1; i + 1 < size; i++) {
        triangle[i - 1][0] = corner[apex];
        triangle[i - 1][1] = corner[(apex + i) % size];
        triangle[i - 1][2] = corner[(apex + i + 1) % size];
    }
    return NULL;
}
