/* Triangle against triangle by signs of exact determinants only, so that no tolerance decides; rounded
 * arithmetic says at most where the contact is. SPDX-License-Identifier: MIT */
#include "geometry/triangle.h"

#include "geometry/predicate.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* Does the line p-q, an edge of the triangle whose third vertex is `own`, separate it from the other one as
 * seen from above? The quick way out, which decides for nearly all neighbours in sheets that are height
 * functions. Only sure signs count. */
static bool edge_separates(const double *p, const double *q, const double *own, const double *const other[3])
{
    const int side = cml_orient2d_fast(p, q, own);
    if (side == 0) return false;
    for (int i = 0; i < 3; i++)
        if (cml_orient2d_fast(p, q, other[i]) != -side) return false;
    return true;
}

/* Whether a vertical plane through an edge of either surely has one triangle on each side. */
static bool apart_from_above(const double *const a[3], const double *const b[3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        if (edge_separates(a[i], a[j], a[k], b) || edge_separates(b[i], b[j], b[k], a)) return true;
    }
    return false;
}

/* Seen from above, is `p` surely outside the wedge that opens at v between its sides through s and t? */
static bool outside_wedge(const double *v, const double *s, const double *t, const double *p)
{
    const int orientation = cml_orient2d_fast(v, s, t);
    return orientation != 0 &&
           (cml_orient2d_fast(v, s, p) == -orientation || cml_orient2d_fast(v, p, t) == -orientation);
}

/* Two wedges at one corner meet elsewhere only if a side of one lies within the other. */
static bool wedges_apart_from_above(const double *const a[3], const double *const b[3])
{
    return outside_wedge(a[0], a[1], a[2], b[1]) && outside_wedge(a[0], a[1], a[2], b[2]) &&
           outside_wedge(b[0], b[1], b[2], a[1]) && outside_wedge(b[0], b[1], b[2], a[2]);
}

/* Rounded: where on a segment the plane is met. That it is met was decided by exact signs before. */
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

/* The point of p-q where a quantity that is `at_p` and `at_q` at its ends vanishes. */
static void put_between(const double *p, const double *q, double at_p, double at_q, double place[3])
{
    const double span = at_p - at_q;
    double t = span != 0.0 ? at_p / span : 0.5;
    t = fmin(fmax(t, 0.0), 1.0);
    for (int k = 0; k < 3; k++) place[k] = p[k] + t * (q[k] - p[k]);
}

/* The two coordinates that are kept when the triangle's plane is looked at along an axis. */
struct view {
    int x, y;
};

/* The exact orientation of three points as the view shows them. */
static int orientation(struct view view, const double *a, const double *b, const double *c)
{
    const double p[2] = {a[view.x], a[view.y]};
    const double q[2] = {b[view.x], b[view.y]};
    const double r[2] = {c[view.x], c[view.y]};
    return cml_orient2d(p, q, r);
}

/* The view in which the triangle is largest; false when it has no area in any. */
static bool choose_view(const double *const t[3], struct view *view)
{
    double area[3];
    cml_vec3_area(t[0], t[1], t[2], area);
    const int first = fabs(area[1]) > fabs(area[0]);
    const int largest = fabs(area[2]) > fabs(area[first]) ? 2 : first;
    *view = (struct view){(largest + 1) % 3, (largest + 2) % 3};
    return orientation(*view, t[0], t[1], t[2]) != 0;
}

/* Whether a point in the triangle's plane lies in the triangle: no edge has it on its outer side; points on
 * the border count. */
static bool contains(struct view view, const double *const t[3], const double *p)
{
    const int whole = orientation(view, t[0], t[1], t[2]);
    for (int i = 0; i < 3; i++)
        if (orientation(view, t[i], t[(i + 1) % 3], p) == -whole) return false;
    return true;
}

/* Two segments in one plane meet when each has the other's ends on both sides of it, or an end on it.
 * Segments on one line do not count here: an end of p-q then lies in the triangle, or p-q passes through a
 * corner, where another edge begins. */
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

/* A segment in the triangle's plane. */
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

/* Signs of volumes of tetrahedra: the ends must be on both sides of the plane, and the line must pass the
 * three edges on the same side. It is a crossing only when it passes strictly inside; all else is a touch. */
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

/* The stronger of what was found and what this segment shows. A crossing cannot be beaten, so the search is
 * over. */
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

/* A whole triangle strictly on one side of the other's plane: the cheap exact test, before six segments are
 * tried. */
static bool on_one_side(const double *const t[3], const double *const other[3])
{
    const int side = cml_orient3d(t[0], t[1], t[2], other[0]);
    return side != 0 && cml_orient3d(t[0], t[1], t[2], other[1]) == side &&
           cml_orient3d(t[0], t[1], t[2], other[2]) == side;
}

/* Triangles without a common vertex meet exactly when an edge of one meets the other. */
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

/* What they have in common beyond the corner a[0] is a segment that begins there and ends on the edge
 * opposite the corner in one of them. */
static enum cml_contact contact_at_corner(const double *const a[3], const double *const b[3], double place[3])
{
    if (wedges_apart_from_above(a, b)) return CML_APART;
    const enum cml_contact found = stronger(CML_APART, a[1], a[2], b, place);
    return stronger(found, b[1], b[2], a, place);
}

/* Neighbours at an edge overlap only when one is folded flat onto the other. */
static enum cml_contact contact_at_edge(const double *const a[3], const double *const b[3], double place[3])
{
    if (cml_orient2d_fast(a[0], a[1], a[2]) * cml_orient2d_fast(a[0], a[1], b[2]) < 0) return CML_APART;
    struct view view;
    if (cml_orient3d(a[0], a[1], a[2], b[2]) != 0 || !choose_view(a, &view)) return CML_APART;
    if (orientation(view, a[0], a[1], a[2]) != orientation(view, a[0], a[1], b[2])) return CML_APART;
    for (int k = 0; k < 3; k++) place[k] = 0.5 * (a[0][k] + a[1][k]);
    return CML_TOUCH;
}

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
