/* Walks a ray over the cells of a sheet to its first crossing. SPDX-License-Identifier: MIT */
#include "surface/mesh/grid_walk.h"

#include "geometry/vec3.h"
#include "surface/tree/rounding.h"

#include <math.h>
#include <stdlib.h>

/* Largest distance, in half widths of the mesh, at which a ray may enter the grid's box. A ray that enters
 * further away is left to the exact query, because t u loses too many digits there. The exact query first
 * moves the ray's origin to the box. */
static const double farthest_entry = 16;

/* A walk begins at the lowest level at which the ray's first and last nodes are fewer than most_nodes nodes
 * apart. For a ray over more nodes, a higher level skips blocks that the ray never comes near. For a ray over
 * fewer nodes, descending costs more than skipping saves. */
static const int most_nodes = 3;

/* Stands for 1 / 0 if a ray does not move along an axis: the ray reaches no border there. It is finite, so
 * that its product with 0 is 0 and not NaN. */
static const double never = 1e300;

/* The answer of a test. UNDECIDED means that rounding could change the answer. It ends the whole traversal,
 * because a later hit may not be the first one. */
enum verdict { MISS, HIT, UNDECIDED };

/* The ray along one axis, in cells from the grid's corner or in depth steps. */
struct axis {
    double origin;  /* position at t = 0, cells or steps */
    double speed;   /* cells or steps per cm of the ray */
    double inverse; /* 1 / speed, cm per cell or step, signed */
};

/* The data of one walk that do not change from node to node. */
struct traversal {
    const struct cml_grid_mesh *grid;
    struct cml_mesh_query *q;
    struct axis axis[2]; /* the ray along x and y */
    struct axis depth;   /* the ray along z, in depth steps */
};

/* A part of the ray, as distances from its origin, cm. */
struct interval {
    double t_min, t_max;
};

/* The nodes of one level from `first` to `last`, both included. A node is a cell (level 0) or a block. */
struct range {
    int first[2], last[2];
};

/* Returns the ray along one axis. If the speed is about 0, the inverse is `never`, which stands for infinity.
 */
static struct axis make_axis(double origin, double speed)
{
    return (struct axis){origin, speed, fabs(speed) > 1 / never ? 1 / speed : never};
}

/* Returns the ray's position along an axis at distance t. */
static double position_at(const struct axis *a, double t)
{
    return a->origin + t * a->speed;
}

/* True if the position, in cells, lies in a grid of n cells. */
static bool is_within(double position, int n)
{
    return position > 0 && position < n;
}

/* Returns the cell of a position in a grid of n cells; the first or last cell if the position is outside. */
static int clamp_to_cell(double position, int n)
{
    return is_within(position, n) ? (int)position : position > 0 ? n - 1 : 0;
}

/* True if the position is inside [low, low + size] by more than rounding. */
static bool is_well_within(double position, double low, double size)
{
    return position - low > err_cell && position - low < size - err_cell;
}

/* True if the ray stays beside the grid along axis k, so that it misses the mesh. */
static bool misses_grid(const struct traversal *w, int k, struct interval ray)
{
    const double first = position_at(&w->axis[k], ray.t_min), last = position_at(&w->axis[k], ray.t_max);
    const double n = w->grid->n[k];
    return (first < -err_cell && last < -err_cell) || (first > n + err_cell && last > n + err_cell);
}

/* Computes barycentric weights of the ray's place at t from areas seen from above. These areas are
 * proportional to the areas in the facet, as the facet is not upright. */
static void find_weights(const struct cml_mesh_query *q, int facet, double t, double weight[3])
{
    const double place[2] = {q->origin[0] + t * q->direction[0], q->origin[1] + t * q->direction[1]};
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        weight[k] = cml_vec2_area(place, cml_centred_corner(q->centred, facet, (k + 1) % 3),
                                  cml_centred_corner(q->centred, facet, (k + 2) % 3));
        sum += weight[k];
    }
    for (int k = 0; k < 3; k++) weight[k] /= sum;
}

/* Adds a hit to the query. Weights are computed only for normals interpolated from vertices, as nothing else
 * uses them. Otherwise equal weights keep the hit away from vertices. */
static void add_hit(struct cml_mesh_query *q, int facet, const double plane[4], double t)
{
    double weight[3] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
    if (q->centred->mesh.normals == CML_NORMALS_VERTEX) find_weights(q, facet, t, weight);
    cml_query_add_inner_hit(q, facet, plane, t, weight);
}

/* Returns the smallest barycentric weight of the ray's place at t in a facet of a sheet; negative outside. */
static double least_weight(const struct cml_mesh_query *q, const struct cml_sheet_facet *f, double t)
{
    const double x = q->origin[0] + t * q->direction[0] - f->corner[0],
                 y = q->origin[1] + t * q->direction[1] - f->corner[1];
    const double b = f->weight[0][0] * x + f->weight[0][1] * y, c = f->weight[1][0] * x + f->weight[1][1] * y;
    const double least = b < c ? b : c, a = 1 - b - c;
    return a < least ? a : least;
}

/* Finds the nearest facet that a ray hits among those listed in a cell. Undecided if rounding could change
 * the answer. The loop has no branches, since most of them would be mispredicted. */
static enum verdict intersect_cell(const struct traversal *w, size_t index, struct interval part)
{
    struct cml_mesh_query *q = w->q;
    const struct cml_grid_mesh *grid = w->grid;
    const double sign = q->below ? 1 : -1, err = err_weight_sheet;
    const double surely_ahead = q->t_min + err_start * q->centred->upper[0];
    const struct cml_sheet_facet *hit = NULL;
    double t_hit = INFINITY;
    int undecided = 0, touches = 0;
    for (uint32_t i = grid->first[index]; i < grid->first[index + 1]; i++) {
        const struct cml_sheet_facet *f = &grid->facet[grid->listed[i]];
        const double along = cml_vec3_dot(q->direction, f->plane), leading_away = sign * along;
        const double height = f->plane[3] - cml_vec3_dot(q->origin, f->plane), t = height / along;
        const double least = least_weight(q, f, t);
        const int counts = (int)grid->listed[i] != q->exclude, grazes = fabs(along) < err_sine_grid;
        const int meets =
            (leading_away >= err_sine_grid) & (t >= part.t_min) & (t <= part.t_max) & !(least < -err);
        const int surely = (least > err) & (t >= surely_ahead),
                  is_first = counts & meets & surely & (t < t_hit);
        touches |= fabs(height) <= q->contact_distance;
        undecided |= counts & (grazes | (meets & !surely));
        t_hit = is_first ? t : t_hit;
        hit = is_first ? f : hit;
    }
    if (touches) q->in_doubt = true;
    if (undecided) return UNDECIDED;
    if (!hit) return MISS;
    add_hit(q, (int)(hit - grid->facet), hit->plane, t_hit);
    return HIT;
}

/* Returns the part of the ray that lies between the depths of a node's facets; empty (t_min > t_max) if there
 * is none. The depths are already widened by more than rounding. A node without facets has least > most.
 * Sorting turns these two into the full range of depths. Such a node is therefore entered, and its cells
 * leave the answer undecided. */
static struct interval clip_to_depths(const struct traversal *w, struct cml_grid_mesh_depths depths,
                                      struct interval part)
{
    const double a = (depths.least - w->depth.origin) * w->depth.inverse,
                 b = (depths.most - w->depth.origin) * w->depth.inverse;
    const double first = a < b ? a : b, last = a < b ? b : a;
    if (first > part.t_min) part.t_min = first;
    if (last < part.t_max) part.t_max = last;
    return part;
}

/* Finds the node of `level`, within the range, in which the ray is at t. Returns false if the ray is too
 * close to the border between two nodes. The outer borders of the range do not count, because the ray is
 * known to be inside the range. */
static bool find_node(const struct traversal *w, int level, const struct range *range, double t, int node[2])
{
    const double size = (double)(1 << 2 * level);
    for (int k = 0; k < 2; k++) {
        const double x = position_at(&w->axis[k], t);
        int i = (int)(x / size);
        if (i < range->first[k]) i = range->first[k];
        if (i > range->last[k]) i = range->last[k];
        if (!(x - i * size > err_cell || i == range->first[k]) ||
            !(x - i * size < size - err_cell || i == range->last[k]))
            return false;
        node[k] = i;
    }
    return true;
}

static enum verdict traverse(const struct traversal *w, int level, const struct range *range, int node[2],
                             double enter, struct interval part);

/* Returns the range of children of a block of `level`: 4 x 4 nodes, fewer at the grid's end. */
static struct range children_of(const struct traversal *w, int level, const int node[2])
{
    const int *n = w->grid->level[level - 1].n;
    struct range range;
    for (int k = 0; k < 2; k++) {
        range.first[k] = 4 * node[k];
        range.last[k] = 4 * node[k] + 3 < n[k] ? 4 * node[k] + 3 : n[k] - 1;
    }
    return range;
}

/* Visits a node, over which the ray is along `part`, and surely at the distance `enter`. Skips the node if
 * the ray stays above or below the depths of its facets. In a cell, tests all listed facets. In a block,
 * walks through the children, from the place where the ray comes within the block's depths. If this place
 * lies on a border between children, the walk starts at `enter`. */
static enum verdict visit_node(const struct traversal *w, int level, const int node[2], double enter,
                               struct interval part)
{
    const struct cml_grid_mesh_level *nodes = &w->grid->level[level];
    const size_t index = cml_grid_mesh_index(nodes, node[0], node[1]);
    const struct interval clipped = clip_to_depths(w, nodes->depths[index], part);
    if (clipped.t_min > clipped.t_max) return MISS;
    if (level == 0) return intersect_cell(w, index, part);
    const struct range range = children_of(w, level, node);
    int first[2];
    if (clipped.t_min > enter && find_node(w, level - 1, &range, clipped.t_min, first))
        return traverse(w, level - 1, &range, first, clipped.t_min, clipped);
    if (!find_node(w, level - 1, &range, enter, first)) return UNDECIDED;
    return traverse(w, level - 1, &range, first, enter, (struct interval){part.t_min, clipped.t_max});
}

/* Returns the distance at which the ray leaves a node along axis k: tMax of Amanatides and Woo. It is
 * computed from the node's number each time, because adding up tDelta would accumulate rounding. */
static double leave_at(const struct traversal *w, int k, int node, double size)
{
    const struct axis *axis = &w->axis[k];
    return ((node + (axis->inverse > 0)) * size - axis->origin) * axis->inverse;
}

/* Walks along the ray through the nodes of a range (Amanatides and Woo), each time across the border that the
 * ray reaches first, until a node is hit or the ray or the range ends. `enter`: a distance in `part` at which
 * the ray is in the first node. Each node tests its part of the ray, widened by err_cell at both ends, so
 * that a facet at a border is tested from both nodes. Returns UNDECIDED if the ray crosses a border near a
 * corner, because the next node is then not certain. */
static enum verdict traverse(const struct traversal *w, int level, const struct range *range, int node[2],
                             double enter, struct interval part)
{
    const double size = (double)(1 << 2 * level);
    const int step[2] = {w->axis[0].inverse > 0 ? 1 : -1, w->axis[1].inverse > 0 ? 1 : -1};
    const double err_t[2] = {err_cell * fabs(w->axis[0].inverse), err_cell * fabs(w->axis[1].inverse)};
    double t_next[2] = {leave_at(w, 0, node[0], size), leave_at(w, 1, node[1], size)};
    for (;;) {
        const int leaving = t_next[1] <= t_next[0], staying = 1 - leaving;
        const double leave = t_next[leaving];
        const double t_max = leave + err_t[leaving] < part.t_max ? leave + err_t[leaving] : part.t_max;
        const enum verdict verdict = visit_node(w, level, node, enter, (struct interval){part.t_min, t_max});
        if (verdict != MISS || leave > part.t_max) return verdict;
        const int next = node[leaving] + step[leaving];
        if (next < range->first[leaving] || next > range->last[leaving]) return MISS;
        if (!is_well_within(position_at(&w->axis[staying], leave), node[staying] * size, size))
            return UNDECIDED;
        node[leaving] = next;
        t_next[leaving] = leave_at(w, leaving, next, size);
        enter = leave;
        part.t_min = leave - err_t[leaving];
    }
}

/* Returns the level at which the ray crosses fewer than most_nodes nodes along each axis. */
static int find_start_level(const struct traversal *w, const int first[2], const double last[2])
{
    int cells = 0, level = 0;
    for (int k = 0; k < 2; k++) {
        const int d = abs(clamp_to_cell(last[k], w->grid->n[k]) - first[k]);
        if (d > cells) cells = d;
    }
    while (cells >> 2 * level >= most_nodes && level + 1 < w->grid->levels) level++;
    return level;
}

/* Finds the first facet that a ray hits, cell by cell, from the cell in which the ray begins; rays over many
 * cells skip blocks of cells. The answer is undecided if the ray begins near a cell's border. It is
 * undecided, too, if nothing is hit and the ray ends near a border, since the cell beyond was not visited. */
static enum verdict traverse_grid(const struct traversal *w, struct interval ray)
{
    const struct cml_grid_mesh *grid = w->grid;
    double last[2];
    int node[2];
    bool ends_inside = true, ends_in_cell = true;
    for (int k = 0; k < 2; k++) {
        const double first = position_at(&w->axis[k], ray.t_min);
        last[k] = position_at(&w->axis[k], ray.t_max);
        node[k] = (int)first;
        if (!is_well_within(first, node[k], 1)) return UNDECIDED;
        ends_inside = ends_inside && is_within(last[k], grid->n[k]);
        ends_in_cell = ends_in_cell && is_well_within(last[k], floor(last[k]), 1);
    }
    const int level = find_start_level(w, node, last);
    const int *n = grid->level[level].n;
    const struct range all = {{0, 0}, {n[0] - 1, n[1] - 1}};
    /* Nodes of each level are four times as wide as those of the level below. */
    for (int k = 0; k < 2; k++) node[k] >>= 2 * level;
    const enum verdict verdict = traverse(w, level, &all, node, ray.t_min, ray);
    return verdict == MISS && ends_inside && !ends_in_cell ? UNDECIDED : verdict;
}

/* A ray that begins far away, or comes from beside the grid and may reach it, stays undecided. */
bool cml_grid_walk(const struct cml_grid_mesh *grid, struct cml_mesh_query *q)
{
    const double size = q->centred->upper[0];
    struct traversal w = {.grid = grid, .q = q};
    for (int k = 0; k < 2; k++)
        w.axis[k] = make_axis((q->origin[k] - grid->corner[k]) * grid->cells_per_cm[k],
                              q->direction[k] * grid->cells_per_cm[k]);
    w.depth = make_axis((q->origin[2] - grid->z) * grid->steps_per_cm, q->direction[2] * grid->steps_per_cm);
    const struct interval whole = {q->grazing_factor * q->t_min - err_start * size, q->t};
    const struct interval ray = clip_to_depths(&w, (struct cml_grid_mesh_depths){0, UINT16_MAX}, whole);
    if (ray.t_min > ray.t_max) return true;
    if (ray.t_min > farthest_entry * size) return false;
    for (int k = 0; k < 2; k++)
        if (!is_within(position_at(&w.axis[k], ray.t_min), grid->n[k]))
            return misses_grid(&w, 0, ray) || misses_grid(&w, 1, ray);
    return traverse_grid(&w, ray) != UNDECIDED;
}

/* The search over cells then finds every crossing, because the plane outside the mesh is out of reach. */
bool cml_grid_walk_covers(const struct cml_grid_mesh *grid, const struct cml_mesh_query *q)
{
    const double err = err_cover_factor * (q->err_position + q->err_entry);
    for (int k = 0; k < 2; k++) {
        const double low = grid->inner[0][k] + err, high = grid->inner[1][k] - err;
        const double first = q->origin[k], last = first + q->t * q->direction[k];
        if (!(first > low && first < high && last > low && last < high)) return false;
    }
    return true;
}
