/* Exact signs of orientations.
 * Exists because "do these surfaces cross?" must have one answer: the sign is that of the exact determinant
 * of the given doubles (a filter in double, expansions where it is unsure). Assumes that no product of three
 * coordinate differences under- or overflows. SPDX-License-Identifier: MIT */
#ifndef CML_PREDICATE_H
#define CML_PREDICATE_H

/* +1 when a, b, c turn counter-clockwise (x right, y up), -1 clockwise, 0 when exactly on one line. */
int cml_orient2d(const double a[2], const double b[2], const double c[2]);

/* The filter alone: 0 also means "unsure". */
int cml_orient2d_fast(const double a[2], const double b[2], const double c[2]);

/* Sign of det(a - d, b - d, c - d): on which side of the plane through a, b, c the point d lies; 0 when
 * exactly on it. */
int cml_orient3d(const double a[3], const double b[3], const double c[3], const double d[3]);

#endif
