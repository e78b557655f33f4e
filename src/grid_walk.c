/* SPDX-License-Identifier: MIT */
#include "grid_walk.h"

#include "vec3.h"

#include <math.h>

/* Product of direction and unit normal below which a facet is left to the exact query: beyond it, rounding
 * moves a crossing by less than the lattice's margin. */
static const double grazing = 1e-4;

/* In halves of the mesh's width: origins further away cost too many digits. */
static const double far = 16;

/* Crossings this close to where they begin to count, in halves of the mesh's width, may be on either side of
 * it. */
static const double start_blur = 1e-10;

enum verdict { MISSED, HIT, OPEN };

/* The ray along one axis, in cells, and the cell that it is in. */
struct axis {
    double origin, speed;
    double next, pace; /* distance at which it leaves the cell; per cell */
    int cell, way;
};

/* The part of the ray over a cell, each end widened by the lattice's margin. */
struct part {
    double from, to;
};

static bool is_clearly_within(const struct axis *a, double t, double margin)
{
    const double at = a->origin + t * a->speed - a->cell;
    return at > margin && at < 1 - margin;
}

static struct axis axis_of(const struct cml_lattice *lattice, const struct cml_mesh_query *q, int k)
{
    return (struct axis){.origin = (q->origin[k] - lattice->corner[k]) * lattice->per_cell[k],
                         .speed = q->direction[k] * lattice->per_cell[k]};
}

/* Finds the cell; false when the ray is outside the lattice at t. */
static bool start(struct axis *a, double t, int n)
{
    const double at = a->origin + t * a->speed;
    if (!(at > 0 && at < n)) return false;
    a->cell = (int)at;
    return true;
}

/* Whether the ray never comes near the lattice. */
static bool passes_by(const struct axis *a, double from, double to, const struct cml_lattice *lattice, int n)
{
    const double b = a->origin + from * a->speed, c = a->origin + to * a->speed, margin = lattice->margin;
    return lattice->is_whole && ((b < -margin && c < -margin) || (b > n + margin && c > n + margin));
}

static void find_next(struct axis *a)
{
    a->way = a->speed > 0 ? 1 : -1;
    a->pace = a->speed != 0 ? a->way / a->speed : INFINITY;
    a->next = a->speed != 0 ? (a->cell + (a->way > 0) - a->origin) * a->way * a->pace : INFINITY;
}

/* How far a place of the cell lies on a facet's side of the diagonal. */
static double inside_diagonal(double u, double v, bool falling, bool south)
{
    const double above = falling ? u + v - 1 : v - u;
    return south ? -above : above;
}

static enum verdict meet(const struct cml_lattice *lattice, const struct cml_mesh_query *q,
                         const struct axis *x, const struct axis *y, const struct cml_lattice_cell *cell,
                         bool south, struct part part, double *t)
{
    const uint32_t facet = (south ? cell->south : cell->north) & ~CML_LATTICE_FALLING;
    const double *plane = q->body->plane[facet], margin = lattice->margin;
    const double along = cml_vec3_dot(q->direction, plane), leading_away = q->below ? along : -along;
    if ((int)facet == q->exclude || leading_away <= -grazing) return MISSED;
    if (leading_away < grazing) return OPEN;
    *t = (plane[3] - cml_vec3_dot(q->origin, plane)) / along;
    if (!(*t >= part.from && *t <= part.to)) return MISSED;
    const bool may_lie_behind = *t < q->least + start_blur * q->body->upper[0];
    const double u = x->origin + *t * x->speed - x->cell, v = y->origin + *t * y->speed - y->cell;
    double inside = u < 1 - u ? u : 1 - u;
    if (v < inside) inside = v;
    if (1 - v < inside) inside = 1 - v;
    if (cell->south != cell->north) {
        const double w = inside_diagonal(u, v, cell->south & CML_LATTICE_FALLING, south);
        if (w < inside) inside = w;
    }
    if (inside < -margin) return MISSED;
    return inside > margin && !may_lie_behind ? HIT : OPEN;
}

/* Barycentric weights of a place above a facet that is not upright. */
static void find_weights(const struct cml_mesh_query *q, int facet, double t, double weight[3])
{
    const struct cml_mesh *mesh = &q->body->mesh;
    const double x = q->origin[0] + t * q->direction[0], y = q->origin[1] + t * q->direction[1];
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        const double *a = mesh->vertex[mesh->triangle[facet][(k + 1) % 3]],
                     *b = mesh->vertex[mesh->triangle[facet][(k + 2) % 3]];
        weight[k] = (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x);
        sum += weight[k];
    }
    for (int k = 0; k < 3; k++) weight[k] /= sum;
}

static void take(struct cml_mesh_query *q, uint32_t facet, double t)
{
    double weight[3] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
    if (q->body->mesh.normals == CML_NORMALS_VERTEX) find_weights(q, (int)facet, t, weight);
    cml_query_take_inside(q, (int)facet, t, weight);
}

static enum verdict look(const struct cml_lattice *lattice, struct cml_mesh_query *q, const struct axis *x,
                         const struct axis *y, struct part part)
{
    const struct cml_lattice_cell *cell =
        &lattice->cell[(size_t)y->cell * (size_t)lattice->n[0] + (size_t)x->cell];
    const double a = q->origin[2] + part.from * q->direction[2], b = q->origin[2] + part.to * q->direction[2];
    if ((a < cell->least && b < cell->least) || (a > cell->most && b > cell->most)) return MISSED;
    if (cell->south == CML_LATTICE_NO_FACET || cell->north == CML_LATTICE_NO_FACET) return OPEN;
    double t = INFINITY, t_north = INFINITY;
    const enum verdict south = meet(lattice, q, x, y, cell, true, part, &t);
    const enum verdict north =
        cell->south == cell->north ? MISSED : meet(lattice, q, x, y, cell, false, part, &t_north);
    if (south == OPEN || north == OPEN) return OPEN;
    if (south == MISSED && north == MISSED) return MISSED;
    const bool take_south = south == HIT && !(north == HIT && t_north < t);
    take(q, (take_south ? cell->south : cell->north) & ~CML_LATTICE_FALLING, take_south ? t : t_north);
    return HIT;
}

/* From cell to cell until one is hit or the ray or the lattice ends. */
static enum verdict walk(const struct cml_lattice *lattice, struct cml_mesh_query *q, struct axis *x,
                         struct axis *y, double from, double to)
{
    const double margin = lattice->margin;
    if (!is_clearly_within(x, from, margin) || !is_clearly_within(y, from, margin)) return OPEN;
    if (is_clearly_within(x, to, margin) && is_clearly_within(y, to, margin))
        return look(lattice, q, x, y, (struct part){from, to});
    find_next(x);
    find_next(y);
    for (;;) {
        struct axis *leaving = x->next < y->next ? x : y, *staying = leaving == x ? y : x;
        const double next = leaving->next, widening = margin * leaving->pace;
        const bool last = next > to;
        const struct part part = {from, next + widening < to ? next + widening : to};
        const enum verdict verdict = look(lattice, q, x, y, part);
        if (verdict != MISSED) return verdict;
        if (last) return is_clearly_within(x, to, margin) && is_clearly_within(y, to, margin) ? MISSED : OPEN;
        if (!is_clearly_within(staying, next, margin)) return OPEN;
        leaving->cell += leaving->way;
        if (leaving->cell < 0 || leaving->cell >= lattice->n[leaving == y])
            return lattice->is_whole ? MISSED : OPEN;
        leaving->next += leaving->pace;
        from = next - widening;
    }
}

/* The cells over which a ray comes within the margin, first and last along each axis; false when some lie
 * outside the lattice, or they are more than a few. */
static bool find_few_cells(const struct cml_lattice *lattice, const struct axis *const axes[2], double from,
                           double to, int first[2], int last[2])
{
    for (int k = 0; k < 2; k++) {
        const double a = axes[k]->origin + from * axes[k]->speed, b = axes[k]->origin + to * axes[k]->speed;
        const double low = (a < b ? a : b) - lattice->margin, high = (a < b ? b : a) + lattice->margin;
        if (!(low > 0 && high < lattice->n[k])) return false;
        first[k] = (int)low;
        last[k] = (int)high;
        if (last[k] - first[k] > 1) return false;
    }
    return true;
}

/* Adds a facet to the list unless it is there; false when it is none, or the ray grazes it. */
static bool list(const struct cml_mesh_query *q, uint32_t mark, int facets[8], int *count)
{
    const int facet = (int)(mark & ~CML_LATTICE_FALLING);
    if (mark == CML_LATTICE_NO_FACET) return false;
    for (int i = 0; i < *count; i++)
        if (facets[i] == facet) return true;
    const double along = cml_vec3_dot(q->direction, q->body->plane[facet]);
    facets[(*count)++] = facet;
    return facet == q->exclude || along > grazing || along < -grazing;
}

/* What the walk left open, where the ray stays above a few cells: their facets as the exact query tests them.
 */
static bool settle(const struct cml_lattice *lattice, struct cml_mesh_query *q, const struct axis *x,
                   const struct axis *y, double from, double to)
{
    const struct axis *const axes[2] = {x, y};
    int first[2], last[2], facets[8], count = 0;
    if (!find_few_cells(lattice, axes, from, to, first, last)) return false;
    for (int j = first[1]; j <= last[1]; j++)
        for (int i = first[0]; i <= last[0]; i++) {
            const struct cml_lattice_cell *cell =
                &lattice->cell[(size_t)j * (size_t)lattice->n[0] + (size_t)i];
            if (!list(q, cell->south, facets, &count) || !list(q, cell->north, facets, &count)) return false;
        }
    double leave, t, weight[3];
    if (!cml_query_approach(q, 0, &leave)) return true;
    for (int i = 0; i < count; i++)
        if (facets[i] != q->exclude && cml_query_cross(q, facets[i], &t, weight))
            cml_query_take(q, facets[i], t, weight);
    return true;
}

/* The part of the ray between the mesh's least and greatest depth; false when there is none. */
static bool clip(const struct cml_mesh_query *q, double *from, double *to)
{
    const double uz = q->direction[2], lower = q->body->lower[2] - q->origin[2],
                 upper = q->body->upper[2] - q->origin[2];
    if (uz == 0) return lower <= 0 && upper >= 0;
    const double a = lower / uz, b = upper / uz, first = a < b ? a : b, last = a < b ? b : a;
    if (first > *from) *from = first;
    if (last < *to) *to = last;
    return *from <= *to;
}

bool cml_grid_walk(const struct cml_lattice *lattice, struct cml_mesh_query *q)
{
    const double size = q->body->upper[0];
    struct axis x = axis_of(lattice, q, 0), y = axis_of(lattice, q, 1);
    double from = q->lenience * q->least - start_blur * size, to = q->t;
    if (to > size && !clip(q, &from, &to)) return true;
    if (from > far * size) return false;
    if (!start(&x, from, lattice->n[0]) || !start(&y, from, lattice->n[1]))
        return passes_by(&x, from, to, lattice, lattice->n[0]) ||
               passes_by(&y, from, to, lattice, lattice->n[1]);
    return walk(lattice, q, &x, &y, from, to) != OPEN || settle(lattice, q, &x, &y, from, to);
}
