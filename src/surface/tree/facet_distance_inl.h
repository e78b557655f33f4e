/* Code, included where cells are filled with distances to many facets: the distance of a place from a facet.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/vec3.h"

#include <math.h>
#include <stdbool.h>

/* A facet in a frame of its own: its longest side begins at corner 0 and lies along the first axis, corner 2
 * is at (foot, height), and the third axis is the normal. Precise for needles, too.
 *
 *                2
 *             .' | '.
 *          .'    |    '.        height
 *         0------+------1
 *           foot
 *         <----base-----> */
struct cml_flat_facet {
    double corner[3], axis[3][3];
    double base, foot, height, per_left, per_right; /* per_left, per_right: 1 / the squares of the other
                                                       sides */
};

/* Computes a facet's own frame: a corner, the longest side as first axis, the second axis in its plane, and
 * sizes. A needle (far longer than wide) gets its second axis in two steps, because rounding may turn the
 * first result; below 1e-12 of its length it gets any. */
static inline void cml_flat_facet_of(const double *corner[3], struct cml_flat_facet *flat)
{
    double side[3][3], length[3];
    int first = 0;
    for (int k = 0; k < 3; k++) {
        cml_vec3_subtract(corner[(k + 1) % 3], corner[k], side[k]);
        length[k] = cml_vec3_dot(side[k], side[k]);
        if (length[k] > length[first]) first = k;
    }
    const int second = (first + 1) % 3, third = (first + 2) % 3;
    cml_vec3_copy(corner[first], flat->corner);
    flat->base = sqrt(length[first]);
    for (int k = 0; k < 3; k++) flat->axis[0][k] = side[first][k] / flat->base;
    flat->foot = -cml_vec3_dot(side[third], flat->axis[0]);
    for (int k = 0; k < 3; k++) flat->axis[1][k] = -side[third][k] - flat->foot * flat->axis[0][k];
    if (cml_vec3_length(flat->axis[1]) < 1e-12 * flat->base)
        for (int k = 0; k < 3; k++) flat->axis[1][k] = k == (fabs(flat->axis[0][0]) < 0.5 ? 0 : 1);
    cml_vec3_normalise(flat->axis[1]);
    cml_vec3_add_scaled(flat->axis[1], -cml_vec3_dot(flat->axis[1], flat->axis[0]), flat->axis[0],
                        flat->axis[1]);
    cml_vec3_normalise(flat->axis[1]);
    cml_vec3_cross(flat->axis[0], flat->axis[1], flat->axis[2]);
    flat->height = -cml_vec3_dot(side[third], flat->axis[1]);
    flat->per_left = 1 / length[third];
    flat->per_right = 1 / length[second];
}

/* Returns the square of the distance from (x, y) to a side that runs from (0, 0) to (a, b). per_square: 1 /
 * its squared length. */
static inline double cml_side_square(double x, double y, double a, double b, double per_square)
{
    const double t = cml_larger(cml_smaller((x * a + y * b) * per_square, 1), 0), dx = x - t * a,
                 dy = y - t * b;
    return dx * dx + dy * dy;
}

/* Returns the square of the distance from (px, py, pz) to a facet: to its plane if the place is over the
 * facet's inside, else to its closest side. */
static inline double cml_flat_square(const struct cml_flat_facet *f, double px, double py, double pz)
{
    const double(*axis)[3] = f->axis, dx = px - f->corner[0], dy = py - f->corner[1], dz = pz - f->corner[2];
    const double x = dx * axis[0][0] + dy * axis[0][1] + dz * axis[0][2],
                 y = dx * axis[1][0] + dy * axis[1][1] + dz * axis[1][2],
                 z = dx * axis[2][0] + dy * axis[2][1] + dz * axis[2][2];
    const double rest = f->base - x, back = f->base - f->foot, off = cml_larger(cml_larger(-x, -rest), 0);
    const double sides = cml_smaller(cml_side_square(x, y, f->foot, f->height, f->per_left),
                                     cml_side_square(rest, y, back, f->height, f->per_right));
    const bool inside = (y >= 0) & (f->height * x >= f->foot * y) & (f->height * rest >= back * y);
    return z * z + (inside ? 0 : cml_smaller(off * off + y * y, sides));
}
