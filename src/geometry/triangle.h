/* Contact of two triangles, decided exactly (predicate.h). Pure geometry: knows no meshes and no scenes.
 * SPDX-License-Identifier: MIT */
#pragma once

enum cml_contact {
    CML_APART,
    CML_TOUCH, /* common points, but no edge of one passes through the inside of the other */
    CML_CROSS,
};

/* Returns how triangles a and b meet. The first `shared` vertices (0..3) are the same corners of one mesh,
 * a[i] and b[i] for i < shared. A common corner or edge alone is no contact; anything beyond it is. Sets
 * `place` to a common point (rounded) unless the triangles are apart. A triangle of zero area has no contact
 * with anything in its own plane. */
enum cml_contact cml_triangle_contact(const double *const a[3], const double *const b[3], int shared,
                                      double place[3]);
