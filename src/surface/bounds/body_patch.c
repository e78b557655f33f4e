/* Makes the patches of cells, and from them the balls: two planes around the surfaces near a cell.
 * SPDX-License-Identifier: MIT */
#include "surface/bounds/body_patch.h"

#include "geometry/vec3.h"
#include "types.h"

#include <math.h>

#define WORTH 3 /* cells of radius that one cell of distance between the planes costs */
#define CUBE 11 /* cells along an edge of the cube that covers the largest radius and CML_CELL_REACH */

static const double radii[] = {1.25, 1.75, 2.5, 4}; /* radii of balls to try, in cells, rising */
#define NUM_RADII (sizeof radii / sizeof *radii)

/* Adds a sphere or the side of a cylinder of radius r. d: vector from its centre or axis to the cell's
 * middle, D: its length. */
static void add_round(int body, const double d[3], double r, struct cml_body_patch *patch)
{
    const double D = cml_vec3_length(d), h = CML_CELL_REACH;
    const double cosine = D > 0 ? (D * D + r * r - h * h) / (2 * D * r) : -1;
    patch->body = D > 0 ? body : CML_PATCH_MIXED;
    cml_vec3_copy(d, patch->normal);
    cml_vec3_normalise(patch->normal);
    patch->cosine = fmax(-1, fmin(cosine, 1));
    patch->lower = r * patch->cosine - D;
    patch->upper = r - D;
}

/* Adds an end face of a cylinder; `sign` times the axis points outwards. height: of the face over the
 * middle. */
static void add_plane(int body, const double axis[3], double sign, double height,
                      struct cml_body_patch *patch)
{
    patch->body = body;
    for (int k = 0; k < 3; k++) patch->normal[k] = sign * axis[k];
    patch->lower = patch->upper = height;
    patch->cosine = 1;
}

/* Adds to a patch the face of a cylinder that comes close: its side or one of its two ends. If two faces come
 * close, two planes are of no use, and the patch becomes mixed. */
static void add_cylinder(int body, const struct cml_convex *cylinder, const double from_end[3], double cell,
                         struct cml_body_patch *patch)
{
    const double h = CML_CELL_REACH, along = cml_vec3_dot(from_end, cylinder->axis) / cell,
                 length = cylinder->length / cell, r = cylinder->radius / cell;
    double d[3];
    for (int k = 0; k < 3; k++) d[k] = from_end[k] / cell - along * cylinder->axis[k];
    const double D = cml_vec3_length(d);
    const bool side = fabs(D - r) <= h && along > -h && along < length + h;
    const bool first = fabs(along) <= h && D < r + h, last = fabs(length - along) <= h && D < r + h;
    if (side + first + last > 1)
        patch->body = CML_PATCH_MIXED;
    else if (first)
        add_plane(body, cylinder->axis, -1, along, patch);
    else if (last)
        add_plane(body, cylinder->axis, 1, length - along, patch);
    else
        add_round(body, d, r, patch);
}

/* A cell with a second body becomes mixed: packets there must ask the bodies themselves. Lengths are stored
 * in widths of the cell. */
void cml_patch_add_convex(int body, const struct cml_convex *convex, const double p[3], double cell,
                          struct cml_body_patch *patch)
{
    double d[3];
    if (patch->body != CML_PATCH_NONE) {
        patch->body = CML_PATCH_MIXED;
        return;
    }
    cml_vec3_subtract(p, convex->centre, d);
    if (convex->form == CML_CONVEX_CYLINDER) {
        add_cylinder(body, convex, d, cell, patch);
        return;
    }
    for (int k = 0; k < 3; k++) d[k] /= cell;
    add_round(body, d, convex->radius / cell, patch);
}

/* The weight is the facet's area, but at most the area that a cell can hold. */
void cml_patch_add_normal(int body, const double corner[3][3], struct cml_body_patch *patch)
{
    double normal[3];
    if (patch->body != CML_PATCH_NONE && patch->body != body) {
        patch->body = CML_PATCH_MIXED;
        return;
    }
    cml_vec3_area(corner[0], corner[1], corner[2], normal);
    const double area = cml_vec3_length(normal);
    if (patch->body == CML_PATCH_NONE) {
        *patch = (struct cml_body_patch){.body = body, .lower = INFINITY, .upper = -INFINITY, .cosine = 1};
    }
    cml_vec3_add_scaled(patch->normal, fmin(area, 1) / area, normal, patch->normal);
}

/* Returns the other leg of a right triangle; 0 if rounding leaves none. */
static inline double leg(double hypotenuse, double other)
{
    return sqrt(cml_larger(0, hypotenuse * hypotenuse - other * other));
}

/* Computes the range of heights, above a plane through the origin, of a second surface within `distance` of
 * the origin. cosine: cosine of the angle between the normals of plane and surface. lower, upper: range of
 * heights of the second surface along its own normal. */
static inline void heights_over(double cosine, double distance, double lower, double upper, double range[2])
{
    const double nearest = lower > 0 ? lower : (upper < 0 ? -upper : 0);
    const double aside = leg(1, cosine) * leg(distance, nearest);
    range[0] = cml_smaller(cosine * lower, cosine * upper) - aside;
    range[1] = cml_larger(cosine * lower, cosine * upper) + aside;
}

/* The heights are those of the facet's corners or, if smaller, of its plane within reach of the cell. */
void cml_patch_add_heights(const double corner[3][3], struct cml_body_patch *patch)
{
    double normal[3], range[2], low = INFINITY, high = -INFINITY;
    if (patch->body < 0) return;
    cml_vec3_area(corner[0], corner[1], corner[2], normal);
    cml_vec3_normalise(normal);
    const double size = cml_vec3_length(patch->normal);
    if (!(size > 0)) {
        patch->body = CML_PATCH_MIXED;
        return;
    }
    const double mean[3] = {patch->normal[0] / size, patch->normal[1] / size, patch->normal[2] / size};
    const double cosine = cml_vec3_dot(normal, mean), height = cml_vec3_dot(normal, corner[0]);
    for (int k = 0; k < 3; k++) {
        const double h = cml_vec3_dot(mean, corner[k]);
        low = fmin(low, h);
        high = fmax(high, h);
    }
    heights_over(cosine, CML_CELL_REACH, height, height, range);
    patch->lower = fmin(patch->lower, fmax(low, range[0]));
    patch->upper = fmax(patch->upper, fmin(high, range[1]));
    patch->cosine = fmin(patch->cosine, cosine);
}

/* A patch seen from the middle of a nearby cell: the vector to the patch's own middle, and the square of its
 * length. */
struct neighbour {
    const struct cml_body_patch *patch;
    double way[3], square;
};

/* Packets skip the cells before the next one. */
void cml_patch_rows(const int n[3], const struct cml_body_patch *patch, const float *distance, int *next)
{
    for (size_t row = 0; row < (size_t)n[2] * (size_t)n[1]; row++)
        for (int x = n[0] - 1, ahead = n[0]; x >= 0; x--) {
            const size_t i = row * (size_t)n[0] + (size_t)x;
            if (!(distance[i] > CML_CELL_REACH || patch[i].body == CML_PATCH_NONE)) ahead = x;
            next[i] = ahead;
        }
}

/* Finds all cells that a surface may pass and that a ball of the largest radius can reach. Returns their
 * number. */
static int find_neighbours(const int n[3], const struct cml_body_patch *patch, const int *next_in_row,
                           const int at[3], struct neighbour found[CUBE * CUBE * CUBE])
{
    int from[3], to[3], count = 0;
    for (int k = 0; k < 3; k++) {
        from[k] = at[k] > CUBE / 2 ? at[k] - CUBE / 2 : 0;
        to[k] = at[k] + CUBE / 2 < n[k] ? at[k] + CUBE / 2 : n[k] - 1;
    }
    for (int z = from[2]; z <= to[2]; z++)
        for (int y = from[1]; y <= to[1]; y++) {
            const size_t row = ((size_t)z * (size_t)n[1] + (size_t)y) * (size_t)n[0];
            for (int x = from[0]; x <= to[0]; x++) {
                x = next_in_row[row + (size_t)x];
                if (x > to[0]) break;
                struct neighbour *next = &found[count++];
                *next = (struct neighbour){.patch = &patch[row + (size_t)x],
                                           .way = {x - at[0], y - at[1], z - at[2]}};
                next->square = cml_vec3_dot(next->way, next->way);
            }
        }
    return count;
}

/* The joint surface of all patches that can reach into a ball: one normal and two planes. */
struct view {
    int body; /* body number, or CML_PATCH_NONE or CML_PATCH_MIXED */
    double normal[3], lower, upper, cosine;
};

/* True if a surface in the neighbour's cell can reach into the ball. */
static bool reaches_into(const struct neighbour *neighbour, double radius)
{
    return neighbour->square < (radius + CML_CELL_REACH) * (radius + CML_CELL_REACH);
}

/* Moves the planes of a view apart to include the surface of a neighbour's patch. Two bounds of the surface's
 * heights are intersected: its range within the neighbour's own cell, and its range within the ball. */
static void add_heights(const struct neighbour *neighbour, double radius, struct view *view)
{
    const struct cml_body_patch *patch = neighbour->patch;
    const double cosine = cml_vec3_dot(view->normal, patch->normal);
    const double up = cml_vec3_dot(neighbour->way, patch->normal),
                 there = cml_vec3_dot(neighbour->way, view->normal);
    const double lower = patch->lower + up, upper = patch->upper + up;
    double own[2], within[2];
    if (lower > radius || upper < -radius) return;
    heights_over(cosine, CML_CELL_REACH, patch->lower, patch->upper, own);
    heights_over(cosine, radius, lower, upper, within);
    view->lower = cml_smaller(view->lower, cml_larger(own[0] + there, within[0]));
    view->upper = cml_larger(view->upper, cml_smaller(own[1] + there, within[1]));
    const double both = cosine * patch->cosine - leg(1, cosine) * leg(1, patch->cosine);
    view->cosine = cml_smaller(view->cosine, cosine > 0 && patch->cosine > 0 ? both : -1);
}

/* Returns the value of a ball, in cells: its radius, less a multiple of the distance between its planes. */
static double worth_of(const struct view *view, double radius)
{
    return radius - WORTH * (view->upper - view->lower);
}

/* Sees what surfaces reach into a ball around a cell, and bounds them by two planes. Returns false if there
 * are none, if they belong to several bodies, or if the ball would be worth less than `most`. */
static bool make_view(const struct neighbour *neighbour, int count, double radius, double most,
                      struct view *view)
{
    *view = (struct view){.body = CML_PATCH_NONE, .lower = INFINITY, .upper = -INFINITY, .cosine = 1};
    for (int i = 0; i < count; i++) {
        const struct cml_body_patch *patch = neighbour[i].patch;
        if (!reaches_into(&neighbour[i], radius)) continue;
        const bool same = view->body == CML_PATCH_NONE || view->body == patch->body;
        view->body = same ? patch->body : CML_PATCH_MIXED;
        if (view->body == CML_PATCH_MIXED) return false;
        cml_vec3_add_scaled(view->normal, 1, patch->normal, view->normal);
    }
    if (!(cml_vec3_length(view->normal) > 0)) return false;
    cml_vec3_normalise(view->normal);
    for (int i = 0; i < count; i++) {
        if (!reaches_into(&neighbour[i], radius)) continue;
        add_heights(&neighbour[i], radius, view);
        if (worth_of(view, radius) < most) return false;
    }
    return view->lower <= view->upper;
}

/* Returns the ball of a view, smaller by CML_CELL_MARGIN than `radius`, with its planes moved apart by this
 * margin. A direction whose component along the normal exceeds `steepest` crosses the surface at most once; 2
 * means that no direction is steep enough. */
static struct cml_body_ball ball_of_view(const struct view *view, double radius)
{
    const double sine = leg(1, view->cosine) + 1e-3;
    const struct cml_body_ball ball = {
        .radius = (float)(radius - CML_CELL_MARGIN),
        .body = view->body,
        .normal = {(float)view->normal[0], (float)view->normal[1], (float)view->normal[2]},
        .lower = (float)(view->lower - CML_CELL_MARGIN),
        .upper = (float)(view->upper + CML_CELL_MARGIN),
        .steepest = (float)(view->cosine > 0 ? sine : 2),
    };
    return ball;
}

/* A ball that contains a surface is good if it is large and its planes are close together. A ball without a
 * surface wins against a ball that is no better. Large balls are tried first, because few other balls must
 * then be computed. */
struct cml_body_ball cml_body_ball_of(const int n[3], const struct cml_body_patch *patch,
                                      const float *distance, const int *next, const int at[3])
{
    const size_t i = ((size_t)at[2] * (size_t)n[1] + (size_t)at[1]) * (size_t)n[0] + (size_t)at[0];
    struct cml_body_ball best = {
        .radius = distance[i], .lower = -1, .upper = -1, .steepest = 2, .body = CML_PATCH_NONE};
    struct neighbour neighbour[CUBE * CUBE * CUBE];
    const int count = distance[i] < radii[NUM_RADII - 1] ? find_neighbours(n, patch, next, at, neighbour) : 0;
    double most = nextafter(distance[i], INFINITY);
    for (size_t r = NUM_RADII; r-- > 0 && count > 0;) {
        struct view view;
        if (radii[r] < most || !make_view(neighbour, count, radii[r], most, &view)) continue;
        most = worth_of(&view, radii[r]);
        best = ball_of_view(&view, radii[r]);
    }
    return best;
}
