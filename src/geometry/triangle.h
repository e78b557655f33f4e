/* Whether and how two triangles meet, decided exactly (predicate.h).
 * Exists apart from the overlap check because it is pure geometry: it knows neither meshes nor scenes.
 * SPDX-License-Identifier: MIT */
#pragma once

enum cml_contact {
    CML_APART,
    CML_TOUCH, /* common points, but no edge of one passes through the inside of the other */
    CML_CROSS,
};

/* Do triangles a and b have points in common? The first `shared` vertices are the same in both (same corner
 * of one mesh: a[i] and b[i] for i < shared, 0..3) and their common corner or edge does not count as contact;
 * anything beyond it does. Writes a common point into `place` (rounded) unless they are apart. Triangles of
 * zero area are apart from everything in their own plane. */
enum cml_contact cml_triangle_contact(const double *const a[3], const double *const b[3], int shared,
                                      double place[3]);
