/* SPDX-License-Identifier: MIT */
#include "oracle.h"

#include "geometry/vec3.h"

#include <math.h>

#define MOST_IN_CELL 32
#define FARTHEST_PERIOD 20 /* largest distance of targets from the middle of a tile [periods] */

static void reach_to(struct oracle *oracle, double z)
{
    oracle->highest = fmin(oracle->highest, z);
    oracle->lowest = fmax(oracle->lowest, z);
}

void oracle_create(const struct cml_surface_def *def, struct oracle *oracle)
{
    *oracle = (struct oracle){.def = def, .highest = INFINITY, .lowest = -INFINITY};
    if (def->kind == CML_SURFACE_PLANE) reach_to(oracle, 0);
    for (int i = 0; def->kind == CML_SURFACE_CONE && i < def->num_rings; i++) reach_to(oracle, def->z[i]);
    if (def->kind != CML_SURFACE_MESH) return;
    const struct cml_mesh *mesh = cml_mesh_surface_mesh(def->mesh, oracle->middle);
    for (size_t i = 0; i < mesh->num_vertices; i++) reach_to(oracle, mesh->vertex[i][2] + oracle->middle[2]);
    const struct cml_mesh_period *period = cml_mesh_surface_period(def->mesh);
    for (int axis = 0; axis < 2; axis++) oracle->period[axis] = period->n[axis] * period->cell[axis];
    oracle_grid_create(mesh, MOST_IN_CELL, &oracle->grid);
}

void oracle_free(struct oracle *oracle)
{
    oracle_grid_free(&oracle->grid);
}

/* ---- the side of a mesh ---- */

/* Writes q relative to the mesh's middle. For a tile, uses the copy of q that lies over the middle period. */
static void seen_from_middle(const struct oracle *oracle, const double q[3], double local[3])
{
    cml_vec3_subtract(q, oracle->middle, local);
    for (int axis = 0; axis < 2; axis++) {
        const double period = oracle->period[axis];
        if (period > 0) local[axis] -= period * rint(local[axis] / period);
    }
}

static const double *corner_of(const struct oracle *oracle, uint32_t triangle, int k)
{
    return oracle->grid.mesh->vertex[oracle->grid.mesh->triangle[triangle][k]];
}

/* Returns +-1 if the edge passes to the right of q, by its direction, else 0. Neighbours compute the same
 * number, so that every point lies in exactly the triangles of one sheet. */
static int passes(const struct cml_mesh *mesh, uint32_t i, uint32_t j, const double q[3])
{
    const bool turned = i > j;
    const double *a = mesh->vertex[turned ? j : i], *b = mesh->vertex[turned ? i : j];
    if ((a[1] > q[1]) == (b[1] > q[1])) return 0;
    if (!(q[0] < a[0] + (q[1] - a[1]) * ((b[0] - a[0]) / (b[1] - a[1])))) return 0;
    return (b[1] > a[1]) != turned ? 1 : -1;
}

static int winding(const struct cml_mesh *mesh, uint32_t triangle, const double q[3])
{
    const uint32_t *v = mesh->triangle[triangle];
    return passes(mesh, v[0], v[1], q) + passes(mesh, v[1], v[2], q) + passes(mesh, v[2], v[0], q);
}

static bool facet_is_above(const struct oracle *oracle, uint32_t triangle, const double q[3])
{
    const double *a = corner_of(oracle, triangle, 0), *b = corner_of(oracle, triangle, 1),
                 *c = corner_of(oracle, triangle, 2);
    const double ux = b[0] - a[0], uy = b[1] - a[1], vx = c[0] - a[0], vy = c[1] - a[1];
    const double x = q[0] - a[0], y = q[1] - a[1], area = ux * vy - uy * vx;
    const double s = (x * vy - y * vx) / area, t = (ux * y - uy * x) / area;
    return a[2] + s * (b[2] - a[2]) + t * (c[2] - a[2]) < q[2];
}

/* Returns the sheets above q, each with its winding. *total: all sheets along the vertical, 0 outside the
 * border. */
static int sheets_above(const struct oracle *oracle, const double q[3], int *total)
{
    const struct oracle_grid *grid = &oracle->grid;
    const struct oracle_box here = {{q[0], q[1]}, {q[0], q[1]}};
    struct oracle_search search =
        oracle_search_cell(grid, oracle_cell_of(grid, 0, q[0]), oracle_cell_of(grid, 1, q[1]), &here);
    uint32_t triangle;
    int above = 0;
    *total = 0;
    while (oracle_next(&search, &triangle)) {
        const int turns = winding(grid->mesh, triangle, q);
        if (turns == 0) continue;
        *total += turns;
        if (facet_is_above(oracle, triangle, q)) above += turns;
    }
    return above;
}

static bool below_mesh(const struct oracle *oracle, const double q[3])
{
    double local[3];
    seen_from_middle(oracle, q, local);
    int total, above = sheets_above(oracle, local, &total);
    const struct cml_mesh *mesh = oracle->grid.mesh;
    if (total == 0 && !mesh->closed && q[2] > mesh->z_border + oracle->middle[2]) above++;
    return above != 0;
}

/* ---- distances ---- */

static double distance_to_segment(const double a[3], const double b[3], const double q[3])
{
    double ab[3], aq[3], off[3];
    cml_vec3_subtract(b, a, ab);
    cml_vec3_subtract(q, a, aq);
    const double square = cml_vec3_dot(ab, ab), t = square > 0 ? cml_vec3_dot(ab, aq) / square : 0;
    const double s = t > 0 ? (t < 1 ? t : 1) : 0;
    for (int axis = 0; axis < 3; axis++) off[axis] = aq[axis] - s * ab[axis];
    return sqrt(cml_vec3_dot(off, off));
}

static double distance_to_triangle(const struct oracle *oracle, uint32_t triangle, const double q[3])
{
    const double *v[3];
    for (int k = 0; k < 3; k++) v[k] = corner_of(oracle, triangle, k);
    double ab[3], ac[3], aq[3], normal[3];
    cml_vec3_subtract(v[1], v[0], ab);
    cml_vec3_subtract(v[2], v[0], ac);
    cml_vec3_subtract(q, v[0], aq);
    cml_vec3_cross(ab, ac, normal);
    bool inside = cml_vec3_dot(normal, normal) > 0;
    double nearest = INFINITY;
    for (int k = 0; k < 3; k++) {
        double edge[3], from[3], across[3];
        cml_vec3_subtract(v[(k + 1) % 3], v[k], edge);
        cml_vec3_subtract(q, v[k], from);
        cml_vec3_cross(edge, from, across);
        inside = inside && cml_vec3_dot(across, normal) >= 0;
        nearest = fmin(nearest, distance_to_segment(v[k], v[(k + 1) % 3], q));
    }
    return inside ? fabs(cml_vec3_dot(aq, normal)) / sqrt(cml_vec3_dot(normal, normal)) : nearest;
}

/* True if the triangle lies farther from q than the distance along one of the axes. */
static bool is_apart(const struct oracle *oracle, uint32_t triangle, const double q[3], double distance)
{
    const double *a = corner_of(oracle, triangle, 0), *b = corner_of(oracle, triangle, 1),
                 *c = corner_of(oracle, triangle, 2);
    for (int axis = 0; axis < 3; axis++) {
        const double low = q[axis] - distance, high = q[axis] + distance;
        if ((a[axis] < low && b[axis] < low && c[axis] < low) ||
            (a[axis] > high && b[axis] > high && c[axis] > high))
            return true;
    }
    return false;
}

static bool near_cell(const struct oracle *oracle, struct oracle_search search, const double q[3],
                      double distance)
{
    uint32_t triangle;
    while (oracle_next(&search, &triangle))
        if (!is_apart(oracle, triangle, q, distance) && distance_to_triangle(oracle, triangle, q) <= distance)
            return true;
    return false;
}

static bool near_mesh(const struct oracle *oracle, const double q[3], double distance)
{
    double local[3];
    seen_from_middle(oracle, q, local);
    const struct oracle_grid *grid = &oracle->grid;
    const struct oracle_box around = {{local[0] - distance, local[1] - distance},
                                      {local[0] + distance, local[1] + distance}};
    int total;
    if (!grid->mesh->closed && fabs(q[2] - (grid->mesh->z_border + oracle->middle[2])) <= distance) {
        sheets_above(oracle, local, &total);
        if (total == 0) return true;
    }
    const int last[2] = {oracle_cell_of(grid, 0, around.high[0]), oracle_cell_of(grid, 1, around.high[1])};
    for (int i = oracle_cell_of(grid, 0, around.low[0]); i <= last[0]; i++)
        for (int j = oracle_cell_of(grid, 1, around.low[1]); j <= last[1]; j++)
            if (near_cell(oracle, oracle_search_cell(grid, i, j, &around), local, distance)) return true;
    return false;
}

/* ---- rings ---- */

static int ring_of(const struct cml_surface_def *def, double r)
{
    int low = 0, high = def->num_rings;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (def->r[middle] <= r)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static double depth_of_rings(const struct cml_surface_def *def, double r)
{
    const int i = ring_of(def, r), last = def->num_rings - 1;
    if (i == last) return def->z[last];
    return def->z[i] + (def->z[i + 1] - def->z[i]) * ((r - def->r[i]) / (def->r[i + 1] - def->r[i]));
}

static bool near_rings(const struct cml_surface_def *def, const double q[3], double distance)
{
    const double r = hypot(q[0], q[1]), at[3] = {r, q[2], 0};
    if (fabs(q[2] - depth_of_rings(def, r)) <= distance) return true;
    const int last = def->num_rings - 1;
    for (int i = ring_of(def, r - distance > 0 ? r - distance : 0); i < last && def->r[i] <= r + distance;
         i++) {
        const double a[3] = {def->r[i], def->z[i], 0}, b[3] = {def->r[i + 1], def->z[i + 1], 0};
        if (distance_to_segment(a, b, at) <= distance) return true;
    }
    return false;
}

/* ---- of any kind ---- */

static bool is_closed(const struct oracle *oracle)
{
    return oracle->def->kind == CML_SURFACE_MESH && oracle->grid.mesh->closed;
}

bool oracle_below(const struct oracle *oracle, const double q[3])
{
    if (q[2] < oracle->highest) return false;
    if (q[2] > oracle->lowest) return !is_closed(oracle);
    if (oracle->def->kind == CML_SURFACE_MESH) return below_mesh(oracle, q);
    return q[2] >
           (oracle->def->kind == CML_SURFACE_CONE ? depth_of_rings(oracle->def, hypot(q[0], q[1])) : 0);
}

bool oracle_near(const struct oracle *oracle, const double q[3], double distance)
{
    if (oracle->def->kind == CML_SURFACE_MESH) return near_mesh(oracle, q, distance);
    if (oracle->def->kind == CML_SURFACE_CONE) return near_rings(oracle->def, q, distance);
    return fabs(q[2]) <= distance;
}

/* ---- places to aim at ---- */

static void unit(double v[3])
{
    const double size = sqrt(cml_vec3_dot(v, v));
    for (int axis = 0; axis < 3; axis++) v[axis] = size > 0 ? v[axis] / size : axis == 2;
}

/* Returns any triangle of the mesh. For a tile it belongs to one period, and half of the time it lies at the
 * seam. */
static uint32_t triangle_to_aim_at(const struct oracle *oracle, struct dice *dice)
{
    const struct cml_mesh_period *period = cml_mesh_surface_period(oracle->def->mesh);
    const int *n = period->n;
    if (n[0] == 0) return (uint32_t)dice_below(dice, (int)oracle->grid.mesh->num_triangles);
    int cell[2] = {dice_below(dice, n[0]), dice_below(dice, n[1])};
    const int seam = dice_below(dice, 8); /* seam along one axis, the other, or both (a corner of the tile) */
    for (int axis = 0; axis < 2; axis++)
        if (seam == axis || seam == 2 + axis || seam == 4) cell[axis] = dice_below(dice, 2) * (n[axis] - 1);
    const int primitive = 2 * (cell[1] * n[0] + cell[0]) + dice_below(dice, 2);
    return (uint32_t)cml_mesh_surface_triangle(oracle->def->mesh, (size_t)primitive);
}

static struct place place_on_mesh(const struct oracle *oracle, enum place_kind kind, struct dice *dice)
{
    const uint32_t triangle = triangle_to_aim_at(oracle, dice);
    const int k = dice_below(dice, 3);
    const double *a = corner_of(oracle, triangle, k), *b = corner_of(oracle, triangle, (k + 1) % 3),
                 *c = corner_of(oracle, triangle, (k + 2) % 3);
    double s = kind == PLACE_VERTEX ? 0 : dice_uniform(dice), t = kind == PLACE_FACE ? dice_uniform(dice) : 0;
    if (s + t > 1) s = 1 - s, t = 1 - t;
    struct place place;
    double ac[3];
    cml_vec3_subtract(b, a, place.tangent);
    cml_vec3_subtract(c, a, ac);
    cml_vec3_cross(place.tangent, ac, place.normal);
    for (int axis = 0; axis < 3; axis++)
        place.point[axis] = a[axis] + s * place.tangent[axis] + t * ac[axis] + oracle->middle[axis];
    place.size = sqrt(cml_vec3_dot(place.tangent, place.tangent));
    for (int axis = 0; axis < 2; axis++)
        place.point[axis] +=
            (dice_below(dice, 2 * FARTHEST_PERIOD + 1) - FARTHEST_PERIOD) * oracle->period[axis];
    unit(place.tangent);
    unit(place.normal);
    return place;
}

/* Returns a random place on rings. Half of the time it lies on a coordinate axis, where x or y is 0 and r is
 * exact. */
static struct place place_on_rings(const struct cml_surface_def *def, enum place_kind kind, struct dice *dice)
{
    const int i = dice_below(dice, def->num_rings), j = i + 1 < def->num_rings ? i + 1 : i - 1;
    const double s = kind == PLACE_FACE ? dice_uniform(dice) : 0;
    const double r = def->r[i] + s * (def->r[j] - def->r[i]), z = def->z[i] + s * (def->z[j] - def->z[i]);
    const double phi = dice_between(dice, 0, 6.283185307179586);
    const int axis = dice_below(dice, 8);
    static const double axes[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const double c = axis < 4 ? axes[axis][0] : cos(phi), d = axis < 4 ? axes[axis][1] : sin(phi);
    const double dr = def->r[j] - def->r[i], dz = def->z[j] - def->z[i];
    struct place place = {{r * c, r * d, z}, {dz * c, dz * d, -dr}, {-d, c, 0}, hypot(dr, dz)};
    if (kind == PLACE_FACE) {
        const double generator[3] = {dr * c, dr * d, dz};
        memcpy(place.tangent, generator, sizeof generator);
        unit(place.tangent);
    }
    unit(place.normal);
    return place;
}

struct place oracle_place(const struct oracle *oracle, enum place_kind kind, struct dice *dice)
{
    if (oracle->def->kind == CML_SURFACE_MESH) return place_on_mesh(oracle, kind, dice);
    if (oracle->def->kind == CML_SURFACE_CONE) return place_on_rings(oracle->def, kind, dice);
    const struct place place = {
        {dice_between(dice, -1, 1), dice_between(dice, -1, 1), 0}, {0, 0, -1}, {1, 0, 0}, 1};
    return place;
}
