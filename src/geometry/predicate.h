/* Exact signs of orientations, so that the question whether surfaces cross has one answer. The sign is that
 * of the exact determinant of the given doubles: a filter computes it in double, and exact expansions take
 * over where the filter is unsure. Assumes that no product of three coordinate differences under- or
 * overflows. SPDX-License-Identifier: MIT */
#pragma once

/* Returns +1 if a, b, c run counter-clockwise (x right, y up), -1 if clockwise, 0 if they lie exactly on one
 * line. */
int cml_orient2d(const double a[2], const double b[2], const double c[2]);

/* Returns the sign of cml_orient2d if the filter is sure of it, else 0. */
int cml_orient2d_fast(const double a[2], const double b[2], const double c[2]);

/* Returns the sign of det(a - d, b - d, c - d): on which side of the plane through a, b, c the point d lies;
 * 0 if exactly in the plane. */
int cml_orient3d(const double a[3], const double b[3], const double c[3], const double d[3]);

/* cml_line_side and cml_plane_side tell which triangles of a sheet a line crosses, and where on the line its
 * origin lies. Both give the signs for the line moved by (e, e^2, e^3) with an e smaller than any number. The
 * moved line never passes through a vertex or an edge, and never begins on a triangle. */

/* Returns the sign of det(u, a - o, b - o): on which side of the edge from a to b the line from o along u
 * passes. 0 only for an edge parallel to u. */
int cml_line_side(const double a[3], const double b[3], const double o[3], const double u[3]);

/* Returns the sign of cml_orient3d(a, b, c, o), with o moved by (e, e^2, e^3) for an infinitely small e > 0.
 * The sign is 0 only for a triangle without area. */
int cml_plane_side(const double a[3], const double b[3], const double c[3], const double o[3]);
