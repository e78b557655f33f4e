/* Exact signs of orientations.
 * Exists because "do these surfaces cross?" must have one answer: the sign is that of the exact determinant
 * of the given doubles (a filter in double, expansions where it is unsure). Assumes that no product of three
 * coordinate differences under- or overflows. SPDX-License-Identifier: MIT */
#pragma once

/* +1 when a, b, c turn counter-clockwise (x right, y up), -1 clockwise, 0 when exactly on one line. */
int cml_orient2d(const double a[2], const double b[2], const double c[2]);

/* The filter alone: 0 also means "unsure". */
int cml_orient2d_fast(const double a[2], const double b[2], const double c[2]);

/* Sign of det(a - d, b - d, c - d): on which side of the plane through a, b, c the point d lies; 0 when
 * exactly on it. */
int cml_orient3d(const double a[3], const double b[3], const double c[3], const double d[3]);

/* The two signs that tell which triangles of a sheet a line crosses, and where on it its origin lies. They
 * are those of the line moved by (e, e^2, e^3) with an e smaller than any number, so that it never passes
 * through a vertex or an edge and never begins on a triangle. */

/* Sign of det(u, a - o, b - o): on which side of the edge from a to b the line from o along u passes. 0 only
 * for an edge along u. */
int cml_line_side(const double a[3], const double b[3], const double o[3], const double u[3]);

/* As cml_orient3d(a, b, c, o). 0 only for a triangle without area. */
int cml_plane_side(const double a[3], const double b[3], const double c[3], const double o[3]);
