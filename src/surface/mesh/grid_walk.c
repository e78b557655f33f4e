/* SPDX-License-Identifier: MIT */
#include "surface/mesh/grid_walk.h"

#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>

/* Product of direction and unit normal below which a facet is left to the exact query: beyond it, rounding
 * moves a crossing by less than the grid's margin. */
static const double grazing = 1e-4;

/* In halves of the mesh's width: origins further away cost too many digits. */
static const double far = 16;

/* Crossings this close to where they begin to count, in halves of the mesh's width, may be on either side of
 * it. */
static const double start_blur = 1e-10;

/* A ray's first cell or block and its last are less than this many apart at the level where its walk begins.
 */
static const int most_blocks = 3;

enum verdict { MISSED, HIT, OPEN };

/* 1 / speed of a ray that does not move along an axis: no part of it ever leaves anything. */
static const double never = 1e300;

/* The ray along one axis, in cells or in steps of depth. */
struct axis {
    double origin, speed, pace; /* pace: distance per cell or step, signed */
};

struct course {
    const struct cml_grid_mesh *grid;
    struct cml_mesh_query *q;
    struct axis axis[2], depth;
};

/* The part of the ray over a cell or a block, each end widened by the grid's margin. */
struct part {
    double from, to;
};

/* Cells, or blocks of one level, from first to last, both included. */
struct range {
    int first[2], last[2];
};

static struct axis axis_of(double origin, double speed)
{
    return (struct axis){origin, speed, fabs(speed) > 1 / never ? 1 / speed : never};
}

static double at(const struct axis *a, double t)
{
    return a->origin + t * a->speed;
}

static bool is_within(double place, int n)
{
    return place > 0 && place < n;
}

/* The cell along an axis; of places outside the grid the nearest. */
static int cell_of(double place, int n)
{
    return is_within(place, n) ? (int)place : place > 0 ? n - 1 : 0;
}

static bool is_clearly_within(double place, double low, double size, double margin)
{
    return place - low > margin && place - low < size - margin;
}

/* Whether the ray never comes near the grid. */
static bool passes_by(const struct course *c, int k, struct part part)
{
    const double b = at(&c->axis[k], part.from), e = at(&c->axis[k], part.to), margin = c->grid->margin,
                 n = c->grid->n[k];
    return c->grid->is_whole && ((b < -margin && e < -margin) || (b > n + margin && e > n + margin));
}

/* How far a place of the cell lies on a facet's side of the diagonal. */
static double inside_diagonal(double u, double v, bool falling, bool south)
{
    const double above = falling ? u + v - 1 : v - u;
    return south ? -above : above;
}

/* plane: of the facet at the cell's south or north side. */
static enum verdict meet(const struct course *c, const int place[2], struct cml_grid_mesh_cell cell,
                         bool south, const double plane[4], struct part part, double *t)
{
    struct cml_mesh_query *q = c->q;
    const uint32_t facet = (south ? cell.south : cell.north) & ~CML_GRID_MESH_FALLING;
    const double margin = c->grid->margin;
    const double along = cml_vec3_dot(q->direction, plane), leading_away = q->below ? along : -along;
    const double height = plane[3] - cml_vec3_dot(q->origin, plane);
    if (fabs(height) <= q->touch) q->doubt = true;
    if ((int)facet == q->exclude || leading_away <= -grazing) return MISSED;
    if (leading_away < grazing) return OPEN;
    *t = height / along;
    if (!(*t >= part.from && *t <= part.to)) return MISSED;
    const bool may_lie_behind = *t < q->least + start_blur * q->body->upper[0];
    const double u = at(&c->axis[0], *t) - place[0], v = at(&c->axis[1], *t) - place[1];
    double inside = u < 1 - u ? u : 1 - u;
    if (v < inside) inside = v;
    if (1 - v < inside) inside = 1 - v;
    if (cell.south != cell.north) {
        const double w = inside_diagonal(u, v, cell.south & CML_GRID_MESH_FALLING, south);
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

static void take(struct cml_mesh_query *q, uint32_t facet, const double plane[4], double t)
{
    double weight[3] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
    if (q->body->mesh.normals == CML_NORMALS_VERTEX) find_weights(q, (int)facet, t, weight);
    cml_query_take_inside(q, (int)facet, plane, t, weight);
}

static enum verdict look(const struct course *c, const int place[2], size_t at_cell, struct part part)
{
    const struct cml_grid_mesh_cell cell = c->grid->cell[at_cell];
    const struct cml_grid_mesh_planes *planes = &c->grid->planes[at_cell];
    if (cell.south == CML_GRID_MESH_NO_FACET || cell.north == CML_GRID_MESH_NO_FACET) return OPEN;
    double t = INFINITY, t_north = INFINITY;
    const enum verdict south = meet(c, place, cell, true, planes->south, part, &t);
    const enum verdict north =
        cell.south == cell.north ? MISSED : meet(c, place, cell, false, planes->north, part, &t_north);
    if (south == OPEN || north == OPEN) return OPEN;
    if (south == MISSED && north == MISSED) return MISSED;
    const bool take_south = south == HIT && !(north == HIT && t_north < t);
    if (take_south)
        take(c->q, cell.south & ~CML_GRID_MESH_FALLING, planes->south, t);
    else
        take(c->q, cell.north & ~CML_GRID_MESH_FALLING, planes->north, t_north);
    return HIT;
}

/* The part in which the ray is between the depths of a cell or a block; ends before it begins where there is
 * none. The depths are wider than rounding; where there are no facets they are all depths, either way. */
static struct part within_depths(const struct course *c, struct cml_grid_mesh_depths depths, struct part part)
{
    const double a = (depths.least - c->depth.origin) * c->depth.pace,
                 b = (depths.most - c->depth.origin) * c->depth.pace;
    const double first = a < b ? a : b, last = a < b ? b : a;
    if (first > part.from) part.from = first;
    if (last < part.to) part.to = last;
    return part;
}

/* Which of the range's parts, cells or blocks of `level`, the ray is in at t; false when that is not clear.
 */
static bool find_place(const struct course *c, int level, const struct range *range, double t, int place[2])
{
    const double size = (double)(1 << 2 * level), margin = c->grid->margin;
    for (int k = 0; k < 2; k++) {
        const double x = at(&c->axis[k], t);
        int i = (int)(x / size);
        if (i < range->first[k]) i = range->first[k];
        if (i > range->last[k]) i = range->last[k];
        if (!(x - i * size > margin || i == range->first[k]) ||
            !(x - i * size < size - margin || i == range->last[k]))
            return false;
        place[k] = i;
    }
    return true;
}

static enum verdict walk(const struct course *c, int level, const struct range *range, int place[2],
                         double enter, struct part part);

/* A cell, or the parts of a block, that the ray enters at `enter`. */
static enum verdict visit(const struct course *c, int level, const int place[2], double enter,
                          struct part part)
{
    const struct cml_grid_mesh_level *blocks = &c->grid->level[level];
    const size_t here = cml_grid_mesh_index(blocks, place[0], place[1]);
    if (level == 0) { /* fetched while the depths are */
        __builtin_prefetch(&c->grid->cell[here]);
        __builtin_prefetch(&c->grid->planes[here]);
    }
    const struct part near = within_depths(c, blocks->depths[here], part);
    if (near.from > near.to) return MISSED;
    if (level == 0) return look(c, place, here, part);
    const int *n = blocks[-1].n;
    struct range range;
    int first[2];
    for (int k = 0; k < 2; k++) {
        range.first[k] = 4 * place[k];
        range.last[k] = 4 * place[k] + 3 < n[k] ? 4 * place[k] + 3 : n[k] - 1;
    }
    if (near.from > enter && find_place(c, level - 1, &range, near.from, first))
        return walk(c, level - 1, &range, first, near.from, near);
    if (!find_place(c, level - 1, &range, enter, first)) return OPEN;
    return walk(c, level - 1, &range, first, enter, (struct part){part.from, near.to});
}

/* From cell to cell, or block to block, of a range until one is hit or the ray or the range ends. `enter`: in
 * part, a distance at which the ray is in the first one. */
static enum verdict walk(const struct course *c, int level, const struct range *range, int place[2],
                         double enter, struct part part)
{
    const double size = (double)(1 << 2 * level), margin = c->grid->margin;
    const int way[2] = {c->axis[0].pace > 0 ? 1 : -1, c->axis[1].pace > 0 ? 1 : -1};
    const double pace[2] = {fabs(c->axis[0].pace), fabs(c->axis[1].pace)};
    double next[2];
    for (int k = 0; k < 2; k++)
        next[k] = ((place[k] + (way[k] > 0)) * size - c->axis[k].origin) * c->axis[k].pace;
    for (;;) {
        const int leaving = next[1] <= next[0], staying = 1 - leaving;
        const double leave = next[leaving], widening = margin * pace[leaving];
        const double to = leave + widening < part.to ? leave + widening : part.to;
        const enum verdict verdict = visit(c, level, place, enter, (struct part){part.from, to});
        if (verdict != MISSED || leave > part.to) return verdict;
        const int onward = place[leaving] + way[leaving];
        if (onward < range->first[leaving] || onward > range->last[leaving]) return MISSED;
        if (!is_clearly_within(at(&c->axis[staying], leave), place[staying] * size, size, margin))
            return OPEN;
        place[leaving] = onward;
        next[leaving] =
            ((onward + (way[leaving] > 0)) * size - c->axis[leaving].origin) * c->axis[leaving].pace;
        enter = leave;
        part.from = leave - widening;
    }
}

/* The cells over which a ray comes within the margin; false when some lie outside the grid, or they are
 * more than a few. */
static bool find_few_cells(const struct course *c, struct part part, struct range *range)
{
    for (int k = 0; k < 2; k++) {
        const double a = at(&c->axis[k], part.from), b = at(&c->axis[k], part.to);
        const double low = (a < b ? a : b) - c->grid->margin, high = (a < b ? b : a) + c->grid->margin;
        if (!(low > 0 && high < c->grid->n[k])) return false;
        range->first[k] = (int)low;
        range->last[k] = (int)high;
        if (range->last[k] - range->first[k] > 1) return false;
    }
    return true;
}

/* Adds a facet to the list unless it is there; false when it is none, or the ray grazes it. */
static bool list(const struct cml_mesh_query *q, uint32_t mark, int facets[8], int *count)
{
    const int facet = (int)(mark & ~CML_GRID_MESH_FALLING);
    if (mark == CML_GRID_MESH_NO_FACET) return false;
    for (int i = 0; i < *count; i++)
        if (facets[i] == facet) return true;
    const double along = cml_vec3_dot(q->direction, q->body->plane[facet]);
    facets[(*count)++] = facet;
    return facet == q->exclude || along > grazing || along < -grazing;
}

/* What the walk left open, where the ray stays above a few cells: their facets as the exact query tests them.
 */
static bool settle(const struct course *c, struct part part)
{
    struct cml_mesh_query *q = c->q;
    struct range range;
    int facets[8], count = 0;
    if (!find_few_cells(c, part, &range)) return false;
    for (int j = range.first[1]; j <= range.last[1]; j++)
        for (int i = range.first[0]; i <= range.last[0]; i++) {
            const struct cml_grid_mesh_cell cell =
                c->grid->cell[cml_grid_mesh_index(&c->grid->level[0], i, j)];
            if (!list(q, cell.south, facets, &count) || !list(q, cell.north, facets, &count)) return false;
        }
    double leave, t, weight[3];
    if (!cml_query_approach(q, 0, &leave)) return true;
    for (int i = 0; i < count; i++) {
        if (facets[i] == q->exclude) continue;
        cml_query_feel(q, facets[i]);
        if (cml_query_cross(q, facets[i], &t, weight)) cml_query_take(q, facets[i], t, weight);
    }
    return true;
}

/* The level at which the ray visits few blocks. */
static int find_level(const struct course *c, const int first[2], const double last[2])
{
    int cells = 0, level = 0;
    for (int k = 0; k < 2; k++) {
        const int d = abs(cell_of(last[k], c->grid->n[k]) - first[k]);
        if (d > cells) cells = d;
    }
    while (cells >> 2 * level >= most_blocks && level + 1 < c->grid->levels) level++;
    return level;
}

/* Where the ray ends near a cell's border, or beyond a grid that is not the whole mesh, missing the cells
 * that it has visited says nothing. */
static enum verdict traverse_grid(const struct course *c, struct part part)
{
    const struct cml_grid_mesh *grid = c->grid;
    double last[2];
    int place[2];
    bool is_inside = true, is_clear = true;
    for (int k = 0; k < 2; k++) {
        const double first = at(&c->axis[k], part.from);
        last[k] = at(&c->axis[k], part.to);
        place[k] = (int)first;
        if (!is_clearly_within(first, place[k], 1, grid->margin)) return OPEN;
        is_inside = is_inside && is_within(last[k], grid->n[k]);
        is_clear = is_clear && is_clearly_within(last[k], floor(last[k]), 1, grid->margin);
    }
    const int level = find_level(c, place, last);
    const int *n = grid->level[level].n;
    const struct range all = {{0, 0}, {n[0] - 1, n[1] - 1}};
    for (int k = 0; k < 2; k++) place[k] >>= 2 * level;
    const enum verdict verdict = walk(c, level, &all, place, part.from, part);
    return verdict == MISSED && !(is_inside ? is_clear : grid->is_whole) ? OPEN : verdict;
}

bool cml_grid_walk(const struct cml_grid_mesh *grid, struct cml_mesh_query *q)
{
    const double size = q->body->upper[0];
    struct course c = {.grid = grid, .q = q};
    for (int k = 0; k < 2; k++)
        c.axis[k] = axis_of((q->origin[k] - grid->corner[k]) * grid->per_cell[k],
                            q->direction[k] * grid->per_cell[k]);
    c.depth = axis_of((q->origin[2] - grid->z) * grid->per_step, q->direction[2] * grid->per_step);
    const struct part whole = {q->lenience * q->least - start_blur * size, q->t};
    const struct part part = within_depths(&c, (struct cml_grid_mesh_depths){0, UINT16_MAX}, whole);
    if (part.from > part.to) return true;
    if (part.from > far * size) return false;
    for (int k = 0; k < 2; k++)
        if (!is_within(at(&c.axis[k], part.from), grid->n[k]))
            return passes_by(&c, 0, part) || passes_by(&c, 1, part);
    return traverse_grid(&c, part) != OPEN || settle(&c, part);
}

bool cml_grid_covers(const struct cml_grid_mesh *grid, const struct cml_mesh_query *q)
{
    const double blur = 64 * (q->slack + q->blur); /* more than crossings may lie behind the packet */
    for (int k = 0; k < 2; k++) {
        const double low = grid->inner[0][k] + blur, high = grid->inner[1][k] - blur;
        const double from = q->origin[k], to = from + q->t * q->direction[k];
        if (!(from > low && from < high && to > low && to < high)) return false;
    }
    return true;
}
