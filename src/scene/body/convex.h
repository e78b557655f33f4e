/* Spheres, cylinders and triangles as convex sets: are two sets apart, and does one lie inside the other?
 * Knows no scene. Lengths in cm. SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

enum cml_convex_form { CML_CONVEX_SPHERE, CML_CONVEX_CYLINDER, CML_CONVEX_TRIANGLE };

/* A convex set: a sphere, a cylinder or a triangle. */
struct cml_convex {
    enum cml_convex_form form;
    double centre[3];       /* centre of a sphere; middle of the first end of a cylinder */
    double axis[3], length; /* cylinder: unit vector and distance to the other end */
    double radius;
    const double *corner[3]; /* corners of a triangle; borrowed */
};

/* The ways in which two sets can lie to each other. */
enum cml_convex_order {
    CML_CONVEX_APART,        /* the sets have no common point */
    CML_CONVEX_FIRST_INSIDE, /* the first set lies inside the second, and not on its surface */
    CML_CONVEX_SECOND_INSIDE,
    CML_CONVEX_MEET,   /* the surfaces cross or touch, or come closer than rounding can resolve */
    CML_CONVEX_OVERLAP /* Only for meshes of several parts, never for convex sets: surfaces are apart, but
                        * only some parts of one lie inside the other. */
};

/* Tells how a and b lie to each other. With CML_CONVEX_MEET `at` is set to a place near both surfaces, else
 * it is left unchanged. A triangle has no inside. Sets are found apart by a plane between them. A set is
 * found inside another in closed form; only for two cylinders its farthest point is searched for. */
enum cml_convex_order cml_convex_compare(const struct cml_convex *a, const struct cml_convex *b,
                                         double at[3]);

/* Finds the point of the solid that is closest to p; this is p itself if p lies inside. */
void cml_convex_project(const struct cml_convex *convex, const double p[3], double closest[3]);

/* Returns the distance from p to the surface, negative inside. Not for triangles. */
double cml_convex_distance(const struct cml_convex *convex, const double p[3]);
