/* Spheres, cylinders and triangles of the tests, in long double: random solids, and geometry by definition.
 * None of it is the program's own geometry. Lengths are in cm.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lib/dice.h"
#include "scene/body/convex.h"

#include <math.h>

typedef long double wide;

static inline wide wide_dot(const wide a[3], const wide b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void wide_from(const double p[3], wide out[3])
{
    for (int k = 0; k < 3; k++) out[k] = p[k];
}

static inline void wide_minus(const wide a[3], const wide b[3], wide out[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[k] - b[k];
}

static inline wide wide_length(const wide a[3])
{
    return sqrtl(wide_dot(a, a));
}

/* Writes the axis as a unit vector to the last bit; an axis in double is not. */
static inline void solid_axis(const struct cml_convex *solid, wide axis[3])
{
    wide_from(solid->axis, axis);
    const wide size = wide_length(axis);
    for (int k = 0; k < 3; k++) axis[k] /= size > 0 ? size : 1;
}

/* Returns the place along the axis of a cylinder. across: the component of p across the axis. */
static inline wide solid_along(const struct cml_convex *solid, const wide p[3], wide across[3])
{
    wide d[3], axis[3], centre[3];
    solid_axis(solid, axis);
    wide_from(solid->centre, centre);
    wide_minus(p, centre, d);
    const wide along = wide_dot(d, axis);
    for (int k = 0; k < 3; k++) across[k] = d[k] - along * axis[k];
    return along;
}

/* Returns the depth of p inside a sphere or cylinder. A negative result says by how much p fails to lie
 * inside. */
static inline wide solid_depth(const struct cml_convex *solid, const wide p[3])
{
    wide across[3];
    const wide along = solid_along(solid, p, across), in_side = solid->radius - wide_length(across);
    if (solid->form == CML_CONVEX_SPHERE) {
        wide d[3], centre[3];
        wide_from(solid->centre, centre);
        wide_minus(p, centre, d);
        return solid->radius - wide_length(d);
    }
    return fminl(in_side, fminl(along, solid->length - along));
}

/* Writes the point of the solid that lies furthest along n. n may have any length. */
static inline void solid_furthest(const struct cml_convex *solid, const wide n[3], wide point[3])
{
    wide axis[3], across[3];
    if (solid->form == CML_CONVEX_TRIANGLE) {
        wide_from(solid->corner[0], point);
        for (int c = 1; c < 3; c++) {
            wide corner[3];
            wide_from(solid->corner[c], corner);
            if (wide_dot(corner, n) > wide_dot(point, n)) memcpy(point, corner, sizeof corner);
        }
        return;
    }
    solid_axis(solid, axis);
    const wide rise = solid->form == CML_CONVEX_CYLINDER ? wide_dot(axis, n) : 0;
    for (int k = 0; k < 3; k++) across[k] = n[k] - rise * axis[k];
    const wide rest = wide_dot(across, axis); /* if n points along the axis, only rounding is left */
    for (int k = 0; k < 3; k++) across[k] -= rest * axis[k];
    const wide size = wide_length(across);
    for (int k = 0; k < 3; k++)
        point[k] = solid->centre[k] + (rise > 0 ? solid->length * axis[k] : 0) +
                   (size > 0 ? solid->radius * across[k] / size : 0);
}

/* Writes a random place on the surface and the outward normal there. part: for a cylinder, 0 is the side, 1
 * and 2 are its ends. */
static inline void solid_surface(const struct cml_convex *solid, int part, struct dice *dice, wide p[3],
                                 wide normal[3])
{
    double u[3];
    dice_direction(dice, u);
    if (solid->form == CML_CONVEX_SPHERE) {
        for (int k = 0; k < 3; k++) {
            normal[k] = u[k];
            p[k] = solid->centre[k] + solid->radius * normal[k];
        }
        return;
    }
    wide axis[3], across[3];
    solid_axis(solid, axis);
    const wide rise = u[0] * axis[0] + u[1] * axis[1] + u[2] * axis[2];
    for (int k = 0; k < 3; k++) across[k] = u[k] - rise * axis[k];
    const wide size = wide_length(across),
               out = part == 0 ? solid->radius : solid->radius * sqrtl(dice_uniform(dice)),
               along = part == 0 ? solid->length * dice_uniform(dice) : (part == 1 ? 0 : solid->length);
    for (int k = 0; k < 3; k++) {
        p[k] = solid->centre[k] + along * axis[k] + out * across[k] / size;
        normal[k] = part == 0 ? across[k] / size : (part == 1 ? -axis[k] : axis[k]);
    }
}

static inline int solid_parts(const struct cml_convex *solid)
{
    return solid->form == CML_CONVEX_SPHERE ? 1 : 3;
}

/* Returns a random solid about the origin, 0.01 to 1 in size. Every third cylinder lies along a coordinate
 * axis. */
static inline struct cml_convex any_solid(enum cml_convex_form form, struct dice *dice)
{
    struct cml_convex solid = {.form = form, .radius = pow(10, dice_between(dice, -2, 0))};
    for (int k = 0; k < 3; k++) solid.centre[k] = dice_between(dice, -0.5, 0.5);
    if (form == CML_CONVEX_SPHERE) return solid;
    dice_direction(dice, solid.axis);
    if (dice_below(dice, 3) == 0) {
        const int along = dice_below(dice, 3);
        for (int k = 0; k < 3; k++) solid.axis[k] = k == along ? 1 : 0;
    }
    solid.length = pow(10, dice_between(dice, -2, 0));
    return solid;
}
