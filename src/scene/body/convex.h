/* Spheres, cylinders and triangles as convex sets: are two of them apart, does one lie inside another?
 * Knows no scene. Lengths in cm. SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

enum cml_convex_form { CML_CONVEX_SPHERE, CML_CONVEX_CYLINDER, CML_CONVEX_TRIANGLE };

struct cml_convex {
    enum cml_convex_form form;
    double centre[3];       /* of a sphere; of a cylinder the middle of its first end */
    double axis[3], length; /* of a cylinder, unit, to the other end */
    double radius;
    const double *corner[3]; /* of a triangle */
};

enum cml_convex_order {
    CML_CONVEX_APART,        /* no common point */
    CML_CONVEX_FIRST_INSIDE, /* the first lies inside the second, and not on its surface */
    CML_CONVEX_SECOND_INSIDE,
    CML_CONVEX_MEET,   /* surfaces cross or touch, or come closer than rounding can tell */
    CML_CONVEX_OVERLAP /* never of convex sets: surfaces are apart, but only parts of one lie in the other */
};

/* How a and b lie to each other; at: with CML_CONVEX_MEET a place near both surfaces, else untouched. A
 * triangle has no inside. What says "apart" is a plane between them; "inside" is a maximum in closed form but
 * for two cylinders, where it is searched for. */
enum cml_convex_order cml_convex_compare(const struct cml_convex *a, const struct cml_convex *b,
                                         double at[3]);

/* The closest point of the solid to p: p itself inside. */
void cml_convex_project(const struct cml_convex *convex, const double p[3], double closest[3]);

/* From p to the surface: below 0 inside. Not for triangles. */
double cml_convex_distance(const struct cml_convex *convex, const double p[3]);
