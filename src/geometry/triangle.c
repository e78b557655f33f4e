/* Contact of two triangles, decided by signs of exact determinants and without tolerances. Rounded arithmetic
 * only gives the place of the contact. SPDX-License-Identifier: MIT */
#include "geometry/triangle.h"

#include "geometry/predicate.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* True if, seen from above, the line p-q separates its own triangle from the other one. p-q is an edge of the
 * triangle whose third vertex is `own`. This quick test settles nearly all pairs of neighbours in sheets that
 * are height functions. Only sure signs count. */
static bool edge_separates(const double *p, const double *q, const double *own, const double *const other[3])
{
    const int side = cml_orient2d_fast(p, q, own);
    if (side == 0) return false;
    for (int i = 0; i < 3; i++)
        if (cml_orient2d_fast(p, q, other[i]) != -side) return false;
    return true;
}

/* True if a vertical plane through an edge of either triangle surely separates the two triangles. */
static bool apart_from_above(const double *const a[3], const double *const b[3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        if (edge_separates(a[i], a[j], a[k], b) || edge_separates(b[i], b[j], b[k], a)) return true;
    }
    return false;
}

/* True if, seen from above, p is surely outside the wedge at v between the directions to s and t. */
static bool outside_wedge(const double *v, const double *s, const double *t, const double *p)
{
    const int orientation = cml_orient2d_fast(v, s, t);
    return orientation != 0 &&
           (cml_orient2d_fast(v, s, p) == -orientation || cml_orient2d_fast(v, p, t) == -orientation);
}

/* True if two triangles with the common corner a[0] surely meet nowhere else, seen from above. Two wedges at
 * one corner meet elsewhere only if a side of one lies inside the other. */
static bool wedges_apart_from_above(const double *const a[3], const double *const b[3])
{
    return outside_wedge(a[0], a[1], a[2], b[1]) && outside_wedge(a[0], a[1], a[2], b[2]) &&
           outside_wedge(b[0], b[1], b[2], a[1]) && outside_wedge(b[0], b[1], b[2], a[2]);
}

/* Returns the rounded determinant det(a - d, b - d, c - d). The caller computes from it where a segment meets
 * a plane, after exact signs have decided that it does. */
static double determinant(const double *a, const double *b, const double *c, const double *d)
{
    double m[3][3];
    for (int k = 0; k < 3; k++) {
        m[0][k] = a[k] - d[k];
        m[1][k] = b[k] - d[k];
        m[2][k] = c[k] - d[k];
    }
    return m[0][2] * (m[1][0] * m[2][1] - m[2][0] * m[1][1]) +
           m[1][2] * (m[2][0] * m[0][1] - m[0][0] * m[2][1]) +
           m[2][2] * (m[0][0] * m[1][1] - m[1][0] * m[0][1]);
}

/* Computes the point of the edge p-q where a linear quantity is zero, which is at_p at p and at_q at q. */
static void put_between(const double *p, const double *q, double at_p, double at_q, double place[3])
{
    const double span = at_p - at_q;
    double t = span != 0.0 ? at_p / span : 0.5;
    t = fmin(fmax(t, 0.0), 1.0);
    for (int k = 0; k < 3; k++) place[k] = p[k] + t * (q[k] - p[k]);
}

/* A projection of a triangle along an axis: the two coordinates that remain. */
struct view {
    int x, y;
};

/* Returns the exact orientation of three points in the projection. */
static int orientation(struct view view, const double *a, const double *b, const double *c)
{
    const double p[2] = {a[view.x], a[view.y]};
    const double q[2] = {b[view.x], b[view.y]};
    const double r[2] = {c[view.x], c[view.y]};
    return cml_orient2d(p, q, r);
}

/* Chooses the projection in which the triangle is largest. Returns false if the triangle has no area in any
 * projection. */
static bool choose_view(const double *const t[3], struct view *view)
{
    double area[3];
    cml_vec3_area(t[0], t[1], t[2], area);
    const int first = fabs(area[1]) > fabs(area[0]);
    const int largest = fabs(area[2]) > fabs(area[first]) ? 2 : first;
    *view = (struct view){(largest + 1) % 3, (largest + 2) % 3};
    return orientation(*view, t[0], t[1], t[2]) != 0;
}

/* True if p, a point in the triangle's plane, lies in the triangle or on its border: no edge has p on its
 * outer side. */
static bool contains(struct view view, const double *const t[3], const double *p)
{
    const int whole = orientation(view, t[0], t[1], t[2]);
    for (int i = 0; i < 3; i++)
        if (orientation(view, t[i], t[(i + 1) % 3], p) == -whole) return false;
    return true;
}

/* True if the segments p-q and a-b, which lie in one plane, meet. They meet if each has the other's ends on
 * both sides, or if an end of one lies on the other. Segments on one line count as not meeting, because other
 * tests find their contact: an end of p-q then lies in the triangle, or p-q passes through a corner, where
 * another edge begins. */
static bool edges_intersect(struct view view, const double *p, const double *q, const double *a,
                            const double *b, double place[3])
{
    const int pa = orientation(view, p, q, a), pb = orientation(view, p, q, b);
    const int ap = orientation(view, a, b, p), aq = orientation(view, a, b, q);
    if (pa * pb > 0 || ap * aq > 0 || (!pa && !pb && !ap && !aq)) return false;
    const double dx = b[view.x] - a[view.x], dy = b[view.y] - a[view.y];
    put_between(p, q, dx * (p[view.y] - a[view.y]) - dy * (p[view.x] - a[view.x]),
                dx * (q[view.y] - a[view.y]) - dy * (q[view.x] - a[view.x]), place);
    return true;
}

/* Says whether the segment p q, which lies in the plane of triangle t, touches t: an end inside, or a
 * crossing with an edge. `place` becomes a common point. A segment in the plane can touch, but not cross. */
static enum cml_contact flat_segment_contact(const double *p, const double *q, const double *const t[3],
                                             double place[3])
{
    struct view view;
    if (!choose_view(t, &view)) return CML_APART;
    const double *const ends[2] = {p, q};
    for (int i = 0; i < 2; i++)
        if (contains(view, t, ends[i])) {
            memcpy(place, ends[i], 3 * sizeof *place);
            return CML_TOUCH;
        }
    for (int i = 0; i < 3; i++)
        if (edges_intersect(view, p, q, t[i], t[(i + 1) % 3], place)) return CML_TOUCH;
    return CML_APART;
}

/* Returns the contact of a segment and a triangle, from signs of tetrahedra's volumes. The segment's ends
 * must lie on both sides of the plane, and its line must pass the three edges on the same side. Contact is a
 * crossing only if the line passes strictly inside; everything else is a touch. */
static enum cml_contact segment_contact(const double *p, const double *q, const double *const t[3],
                                        double place[3])
{
    const int at_p = cml_orient3d(t[0], t[1], t[2], p);
    const int at_q = cml_orient3d(t[0], t[1], t[2], q);
    if (at_p * at_q > 0) return CML_APART;
    if (at_p == 0 && at_q == 0) return flat_segment_contact(p, q, t, place);
    int left = 0, right = 0;
    for (int i = 0; i < 3; i++) {
        const int side = cml_orient3d(p, q, t[i], t[(i + 1) % 3]);
        left += side > 0;
        right += side < 0;
    }
    if (left && right) return CML_APART;
    put_between(p, q, determinant(t[0], t[1], t[2], p), determinant(t[0], t[1], t[2], q), place);
    return at_p && at_q && left + right == 3 ? CML_CROSS : CML_TOUCH;
}

/* Returns the stronger of `found` and the contact of one more segment. Nothing is stronger than a crossing,
 * so no search follows one. */
static enum cml_contact stronger(enum cml_contact found, const double *p, const double *q,
                                 const double *const t[3], double place[3])
{
    double here[3];
    if (found == CML_CROSS) return found;
    const enum cml_contact now = segment_contact(p, q, t, here);
    if (now <= found) return found;
    memcpy(place, here, sizeof here);
    return now;
}

/* True if one triangle lies strictly on one side of the other's plane: a cheap exact test, done before six
 * segments are tried. */
static bool on_one_side(const double *const t[3], const double *const other[3])
{
    const int side = cml_orient3d(t[0], t[1], t[2], other[0]);
    return side != 0 && cml_orient3d(t[0], t[1], t[2], other[1]) == side &&
           cml_orient3d(t[0], t[1], t[2], other[2]) == side;
}

/* Returns the contact of two triangles without a common vertex. They meet exactly if an edge of one meets the
 * other. */
static enum cml_contact contact_of_separate(const double *const a[3], const double *const b[3],
                                            double place[3])
{
    if (apart_from_above(a, b) || on_one_side(a, b) || on_one_side(b, a)) return CML_APART;
    enum cml_contact found = CML_APART;
    for (int i = 0; i < 3; i++) {
        found = stronger(found, a[i], a[(i + 1) % 3], b, place);
        found = stronger(found, b[i], b[(i + 1) % 3], a, place);
    }
    return found;
}

/* Returns the contact of two triangles with the common corner a[0]. A common segment that begins at the
 * corner ends on the edge opposite to it, in one of the two triangles. */
static enum cml_contact contact_at_corner(const double *const a[3], const double *const b[3], double place[3])
{
    if (wedges_apart_from_above(a, b)) return CML_APART;
    const enum cml_contact found = stronger(CML_APART, a[1], a[2], b, place);
    return stronger(found, b[1], b[2], a, place);
}

/* Returns the contact of two triangles with a common edge. They overlap only if one is folded flat onto the
 * other. */
static enum cml_contact contact_at_edge(const double *const a[3], const double *const b[3], double place[3])
{
    if (cml_orient2d_fast(a[0], a[1], a[2]) * cml_orient2d_fast(a[0], a[1], b[2]) < 0) return CML_APART;
    struct view view;
    if (cml_orient3d(a[0], a[1], a[2], b[2]) != 0 || !choose_view(a, &view)) return CML_APART;
    if (orientation(view, a[0], a[1], a[2]) != orientation(view, a[0], a[1], b[2])) return CML_APART;
    for (int k = 0; k < 3; k++) place[k] = 0.5 * (a[0][k] + a[1][k]);
    return CML_TOUCH;
}

/* Says how triangles a and b meet, and stores one common point in `place`. `shared` is the number of corners
 * that both have, which stand first in a and b. Three shared corners make the triangles equal, hence they
 * touch. */
enum cml_contact cml_triangle_contact(const double *const a[3], const double *const b[3], int shared,
                                      double place[3])
{
    switch (shared) {
    case 0:
        return contact_of_separate(a, b, place);
    case 1:
        return contact_at_corner(a, b, place);
    case 2:
        return contact_at_edge(a, b, place);
    default:
        memcpy(place, a[0], 3 * sizeof *place);
        return CML_TOUCH;
    }
}
