/* Computes errors from the finest triangles upwards, then walks triangles from the squares downwards.
 * SPDX-License-Identifier: MIT */
#include "scene/heightmap/heightmap_split.h"

#include <math.h>
#include <stdlib.h>

enum { LARGEST_SQUARE = 256 };

struct point {
    int x, y;
};

/* A right-angled triangle, counter-clockwise: a and b end its longest side, c is the right angle. */
struct triangle {
    struct point a, b, c;
};

enum place { INSIDE, OUTSIDE, ACROSS };

static struct point middle(struct point a, struct point b)
{
    return (struct point){(a.x + b.x) / 2, (a.y + b.y) / 2};
}

/* True if a point of the binary subdivision is a sample of the map; the subdivided square may be larger than
 * the map. */
static bool on_map(const struct cml_heightmap *map, struct point p)
{
    return p.x < map->nx && p.y < map->ny;
}

static size_t index_of(const struct cml_heightmap *map, struct point p)
{
    return (size_t)p.y * (size_t)map->nx + (size_t)p.x;
}

/* Tells whether a triangle lies on the map. Squares begin at sample 0, 0 and may reach beyond the last row
 * and column. Triangles there are halved until they lie inside or outside. */
static enum place place_of(const struct cml_heightmap *map, const struct triangle *t)
{
    if (on_map(map, t->a) && on_map(map, t->b) && on_map(map, t->c)) return INSIDE;
    const int x = map->nx - 1, y = map->ny - 1;
    const bool right = t->a.x >= x && t->b.x >= x && t->c.x >= x;
    const bool above = t->a.y >= y && t->b.y >= y && t->c.y >= y;
    return right || above ? OUTSIDE : ACROSS;
}

/* Halves a triangle at the middle of its longest side. Both halves are right-angled again, at the new
 * middle. */
static void bisect(const struct triangle *t, struct triangle half[2])
{
    const struct point m = middle(t->a, t->b);
    half[0] = (struct triangle){t->c, t->a, m};
    half[1] = (struct triangle){t->b, t->c, m};
}

/* ---- errors ---- */

/* Returns the largest vertical distance between the samples in a triangle and the triangle's plane. za, zb,
 * zc: heights of the corners a, b, c. depths: how many times the triangle can be halved. At the middle of a
 * side the plane's height is the mean of the heights at both ends. */
static double largest_error(const struct cml_heightmap *map, const struct triangle *t, int depths, double za,
                            double zb, double zc)
{
    if (depths == 0) return 0;
    struct triangle half[2];
    bisect(t, half);
    const double zm = (za + zb) / 2, here = fabs(map->h[index_of(map, half[0].c)] - zm);
    const double first = largest_error(map, &half[0], depths - 1, zc, za, zm);
    const double second = largest_error(map, &half[1], depths - 1, zb, zc, zm);
    return fmax(here, fmax(first, second));
}

/* True if a side lies on the rim and is longer than CML_RIM_CELLS cells. Such a side would make the skirt's
 * triangle a needle, far longer than wide. */
static bool spans_rim(const struct cml_heightmap *map, struct point a, struct point b)
{
    const bool upright = a.x == b.x && (a.x == 0 || a.x == map->nx - 1);
    const bool level = a.y == b.y && (a.y == 0 || a.y == map->ny - 1);
    return (upright || level) && abs(a.x - b.x) + abs(a.y - b.y) > CML_RIM_CELLS;
}

/* Returns the error of a triangle if it is not halved. Infinite: the triangle must be halved. */
static double own_error(const struct cml_split *split, const struct triangle *t, int depth)
{
    const struct cml_heightmap *map = split->map;
    if (place_of(map, t) != INSIDE || spans_rim(map, t->a, t->b)) return INFINITY;
    return largest_error(map, t, split->depths - depth, map->h[index_of(map, t->a)],
                         map->h[index_of(map, t->b)], map->h[index_of(map, t->c)]);
}

/* Raises the error at a triangle's middle to its own error, and to the errors of the middles below it. Errors
 * are thereby saturated: no middle has a smaller error than a middle below it. One comparison then decides
 * whether to stop halving, and both triangles at a side decide alike [P. Lindstrom and V. Pascucci,
 * Visualization of large terrains made easy, IEEE Visualization 2001]. */
static void gather_error(struct cml_split *split, const struct triangle *t, int depth)
{
    const struct cml_heightmap *map = split->map;
    const struct point m = middle(t->a, t->b), below[2] = {middle(t->c, t->a), middle(t->b, t->c)};
    if (!on_map(map, m)) return;
    double *error = &split->error[index_of(map, m)];
    *error = fmax(*error, own_error(split, t, depth));
    for (int i = 0; i < 2 && depth + 1 < split->depths; i++)
        if (on_map(map, below[i])) *error = fmax(*error, split->error[index_of(map, below[i])]);
}

/* Gathers the errors of all triangles of one depth, because errors below a middle must be complete before the
 * middle's own. Descending anew for every depth costs no memory; there are at most 16 depths. */
static void gather_errors(struct cml_split *split, const struct triangle *t, int depth, int wanted)
{
    if (place_of(split->map, t) == OUTSIDE) return;
    if (depth == wanted) {
        gather_error(split, t, depth);
        return;
    }
    struct triangle half[2];
    bisect(t, half);
    for (int i = 0; i < 2; i++) gather_errors(split, &half[i], depth + 1, wanted);
}

/* ---- squares ---- */

/* Cuts a square into two triangles along its rising diagonal. */
static void square_at(int x, int y, int size, struct triangle half[2])
{
    const struct point low = {x, y}, high = {x + size, y + size};
    half[0] = (struct triangle){high, low, {x + size, y}};
    half[1] = (struct triangle){low, high, {x, y + size}};
}

cml_status cml_split_create(const struct cml_heightmap *map, struct cml_split *split, struct cml_error *err)
{
    const int cells = (map->nx < map->ny ? map->nx : map->ny) - 1;
    *split = (struct cml_split){.map = map, .size = 1};
    for (; split->size < cells && split->size < LARGEST_SQUARE; split->size *= 2) split->depths += 2;
    const size_t count = (size_t)map->nx * (size_t)map->ny;
    split->error = calloc(count, sizeof *split->error);
    if (!split->error) return cml_fail_memory(err, 8 * (double)count, "a heightmap");
    for (int wanted = split->depths - 1; wanted >= 0; wanted--)
        for (int y = 0; y + 1 < map->ny; y += split->size)
            for (int x = 0; x + 1 < map->nx; x += split->size) {
                struct triangle half[2];
                square_at(x, y, split->size, half);
                for (int i = 0; i < 2; i++) gather_errors(split, &half[i], 0, wanted);
            }
    return CML_OK;
}

void cml_split_free(struct cml_split *split)
{
    free(split->error);
    *split = (struct cml_split){0};
}

/* ---- what is left ---- */

/* The arguments of cml_split_walk. */
struct walk {
    const struct cml_split *split;
    double tolerance;
    double *surface;
    cml_split_visit *visit;
    void *context;
};

/* Fills `surface` with the heights that a merged triangle has at the samples inside it. za, zb, zc: heights
 * of its corners. */
static void fill_surface(const struct walk *walk, const struct triangle *t, int depths, double za, double zb,
                         double zc)
{
    const struct cml_heightmap *map = walk->split->map;
    if (depths == 0) return;
    struct triangle half[2];
    bisect(t, half);
    const double zm = (za + zb) / 2;
    walk->surface[index_of(map, half[0].c)] = zm;
    fill_surface(walk, &half[0], depths - 1, zc, za, zm);
    fill_surface(walk, &half[1], depths - 1, zb, zc, zm);
}

/* Accepts a triangle of the mesh as fine enough: fills in the heights of the samples that it covers, and
 * passes its corners to the caller. */
static void keep_triangle(const struct walk *walk, const struct triangle *t, int depth)
{
    const struct cml_heightmap *map = walk->split->map;
    const size_t corner[3] = {index_of(map, t->a), index_of(map, t->b), index_of(map, t->c)};
    for (int k = 0; k < 3; k++) walk->surface[corner[k]] = map->h[corner[k]];
    fill_surface(walk, t, walk->split->depths - depth, map->h[corner[0]], map->h[corner[1]],
                 map->h[corner[2]]);
    walk->visit(walk->context, corner);
}

/* Refines a triangle: halves it, and its halves in turn, until the error at the middle is within the
 * tolerance. The errors at all middles below are then within the tolerance, too. */
static void refine(const struct walk *walk, const struct triangle *t, int depth)
{
    const struct cml_split *split = walk->split;
    const struct point m = middle(t->a, t->b);
    const enum place place = place_of(split->map, t);
    if (place == OUTSIDE) return;
    if (place == INSIDE &&
        (depth == split->depths || split->error[index_of(split->map, m)] <= walk->tolerance)) {
        keep_triangle(walk, t, depth);
        return;
    }
    struct triangle half[2];
    bisect(t, half);
    for (int i = 0; i < 2; i++) refine(walk, &half[i], depth + 1);
}

/* Begins with squares of at most 256 x 256 cells. Merged, such a square is 2 triangles instead of 131072, and
 * larger squares would save hardly more. */
void cml_split_walk(const struct cml_split *split, double tolerance, double *surface, cml_split_visit *visit,
                    void *context)
{
    const struct walk walk = {split, tolerance, surface, visit, context};
    for (int y = 0; y + 1 < split->map->ny; y += split->size)
        for (int x = 0; x + 1 < split->map->nx; x += split->size) {
            struct triangle half[2];
            square_at(x, y, split->size, half);
            for (int i = 0; i < 2; i++) refine(&walk, &half[i], 0);
        }
}
