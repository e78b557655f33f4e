/* SPDX-License-Identifier: MIT */
#include "surface/bounds/safe_map.h"

#include "base/array.h"
#include "geometry/box_tree.h"
#include "geometry/footprint.h"
#include "geometry/vec3.h"
#include "surface/tree/facet_distance_inl.h"

#include <stdlib.h>

#define CELLS_PER_EDGE 6 /* of a mean facet */
#define MOST_ALONG 64    /* cells along the longest side of the box, for a cache's sake */
#define AROUND 2         /* cells on every side of the box */
#define FAR 8            /* times a block's reach: there its middle speaks for all of its cells */
#define COARSE 2         /* cells along the edge of a mean facet, from which blocks collect facets */

struct filling {
    struct cml_arrays arrays;
    const struct cml_centred_mesh *centred;
    struct cml_flat_facet *flat; /* [num_triangles] */
    uint32_t *leaf;              /* [num_triangles] which has the facet */
    uint32_t *found, *closest; /* [num_triangles] what a block of 4 cells has collected, and of that a part */
    double (*square)[CML_PLACES]; /* [2 num_triangles] from its parts, and from their cells, cm2 */
    size_t collected;
    struct cml_boxtree *tree;
    const struct cml_tree_level *level;
    const struct cml_safe_map *map;
};

/* A cube of 2^level cells along an edge. */
struct block {
    int level, at[3]; /* its first cell */
    double middle[3]; /* in cells */
    uint32_t facet;   /* the closest to that */
};

static double distance(const double a[3], const double b[3])
{
    double way[3];
    cml_vec3_subtract(a, b, way);
    return cml_vec3_length(way);
}

static double facet_square(const void *context, uint32_t i, const double p[3])
{
    return cml_flat_square((const struct cml_flat_facet *)context + i, p[0], p[1], p[2]);
}

/* A place of the map, in cells, in the centred frame, cm. */
static void place_of(const struct filling *f, const double p[3], double at[3])
{
    cml_vec3_add_scaled(f->map->corner, f->map->cell, p, at);
}

/* The distance from a place to the closest facet, in cells. */
static double closest_facet(const struct filling *f, const double p[3], uint32_t *facet)
{
    double at[3];
    place_of(f, p, at);
    return sqrt(cml_boxtree_closest(f->tree, at, facet_square, f->flat, facet)) / f->map->cell;
}

/* Beyond the border the outer plane may be closer. Inside of it the closest place of that plane is on the
 * border, which the facets have. */
static double with_outer_plane(const struct filling *f, const double p[3], double facets)
{
    double at[3];
    if (!f->centred->footprint) return facets;
    place_of(f, p, at);
    const double plane = fabs(at[2] - f->centred->mesh.z_border) / f->map->cell;
    return plane < facets && !cml_footprint_contains(f->centred->footprint, at[0], at[1]) ? plane : facets;
}

/* Rounded down by more than double and float round. */
static float rounded_down(double cells)
{
    return (float)fmax(0, (1 - 1e-6) * cells - 1e-9);
}

static void set_cell(const struct cml_safe_map *map, int x, int y, int z, double safe)
{
    map->safe[((size_t)z * (size_t)map->n[1] + (size_t)y) * (size_t)map->n[0] + (size_t)x] =
        rounded_down(safe);
}

/* All cells of a block, from the safe distance of its middle: another place is closer to the surface by at
 * most the way to it. */
static void set_far_block(const struct cml_safe_map *map, const struct block *block, double safe)
{
    int end[3];
    for (int k = 0; k < 3; k++) {
        const int last = block->at[k] + (1 << block->level);
        end[k] = last < map->n[k] ? last : map->n[k];
    }
    for (int z = block->at[2]; z < end[2]; z++)
        for (int y = block->at[1]; y < end[1]; y++)
            for (int x = block->at[0]; x < end[0]; x++) {
                const double cell[3] = {x + 0.5, y + 0.5, z + 0.5};
                set_cell(map, x, y, z, safe - distance(cell, block->middle));
            }
}

/* The i-th part of a block of more than one cell; false where that has no cells. */
static bool part_of(const struct cml_safe_map *map, const struct block *block, int i, struct block *part)
{
    bool has_cells = true;
    *part = *block;
    part->level--;
    for (int k = 0; k < 3; k++) {
        part->at[k] += (i >> k & 1) << part->level;
        part->middle[k] = part->at[k] + 0.5 * (1 << part->level);
        has_cells = has_cells && part->at[k] < map->n[k];
    }
    return has_cells;
}

/* From the middle of a block to those of its cells, at most, cells. */
static double reach_of(const struct block *block)
{
    return 0.8660255 * ((1 << block->level) - 1);
}

static bool is_far(const struct block *block, double safe)
{
    return safe >= FAR * reach_of(block);
}

/* The middles of a block's parts in the centred frame, cm. */
static void middles_of_parts(const struct filling *f, const struct block *block, double middle[3][CML_PLACES])
{
    for (int i = 0; i < CML_PLACES; i++) {
        struct block part;
        double at[3];
        part_of(f->map, block, i, &part);
        place_of(f, part.middle, at);
        for (int k = 0; k < 3; k++) middle[k][i] = at[k];
    }
}

/* A block of 2 x 2 x 2 cells, by the facets that may be closest to any. */
static void set_cells(const struct filling *f, const struct block *block, const uint32_t *facets,
                      size_t count)
{
    double middle[3][CML_PLACES], least[CML_PLACES], (*square)[CML_PLACES] = f->square + f->collected;
    middles_of_parts(f, block, middle);
    f->level->squares(f->flat, facets, count, middle, square);
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < CML_PLACES; k++) least[k] = cml_smaller(i ? least[k] : INFINITY, square[i][k]);
    for (int i = 0; i < CML_PLACES; i++) {
        struct block cell;
        if (part_of(f->map, block, i, &cell))
            set_cell(f->map, cell.at[0], cell.at[1], cell.at[2],
                     with_outer_plane(f, cell.middle, sqrt(least[i]) / f->map->cell));
    }
}

/* Leaves by the square of the distance of their closest facet so far, cm2; one more than are named. */
struct ranking {
    int count;
    double square[CML_NAMED_LEAVES + 1];
    uint32_t leaf[CML_NAMED_LEAVES + 1];
};

static void rank(struct ranking *r, uint32_t leaf, double square)
{
    int k = 0;
    while (k < r->count && r->leaf[k] != leaf) k++;
    if (k > CML_NAMED_LEAVES)
        k--;
    else if (k == r->count)
        r->square[r->count++] = INFINITY;
    if (square >= r->square[k]) return;
    for (; k > 0 && r->square[k - 1] > square; k--) {
        r->square[k] = r->square[k - 1];
        r->leaf[k] = r->leaf[k - 1];
    }
    r->square[k] = square;
    r->leaf[k] = leaf;
}

/* How far from a place names are good at most: up to the outer plane, for which nobody asks by them, where
 * the border is no further than that or the place is beyond it. */
static double without_outer_plane(const struct filling *f, const double p[3])
{
    const double most = CML_MOST_REACH;
    const struct cml_footprint *footprint = f->centred->footprint;
    double at[3];
    place_of(f, p, at);
    if (!footprint || (cml_footprint_contains(footprint, at[0], at[1]) &&
                       !cml_footprint_border_is_near(footprint, at[0], at[1], most * f->map->cell)))
        return most;
    return cml_smaller(most, fabs(at[2] - f->centred->mesh.z_border) / f->map->cell);
}

/* Names the leaves of a block of 2 x 2 x 2 cells: each is good up to the next one, or the outer plane. */
static void name_leaves(const struct filling *f, const struct block *block, const struct ranking *r)
{
    const struct cml_safe_map *map = f->map;
    const size_t x = (size_t)block->at[0] / 2, y = (size_t)block->at[1] / 2, z = (size_t)block->at[2] / 2;
    struct cml_named_leaves *names =
        &map->names[(z * (size_t)map->blocks[1] + y) * (size_t)map->blocks[0] + x];
    const double most = without_outer_plane(f, block->middle);
    for (int k = 0; k < CML_NAMED_LEAVES; k++) {
        const double next = k + 1 < r->count ? sqrt(r->square[k + 1]) / map->cell : INFINITY;
        names->reach[k] = rounded_down(cml_smaller(next, most));
        names->leaf[k] = r->leaf[k];
    }
}

/* A block of 2 x 2 x 2 cells, by what its parent has collected; column: of squares from its middle. */
static void fill_part(const struct filling *f, const struct block *block, int column)
{
    struct ranking ranking = {.count = 0};
    double least = INFINITY;
    size_t count = 0;
    for (size_t i = 0; i < f->collected; i++) least = cml_smaller(least, f->square[i][column]);
    const double facets = sqrt(least) / f->map->cell, safe = with_outer_plane(f, block->middle, facets),
                 most = 1.000001 * f->map->cell * (facets + 2 * reach_of(block)),
                 named = f->map->cell * CML_MOST_REACH;
    if (is_far(block, safe)) {
        set_far_block(f->map, block, safe);
        return;
    }
    for (size_t i = 0; i < f->collected; i++) {
        const double square = f->square[i][column];
        if (square <= named * named) rank(&ranking, f->leaf[f->found[i]], square);
        if (square <= most * most) f->closest[count++] = f->found[i];
    }
    name_leaves(f, block, &ranking);
    set_cells(f, block, f->closest, count);
}

static void collect(void *context, uint32_t facet)
{
    struct filling *f = context;
    f->found[f->collected++] = facet;
}

/* A block of 4 x 4 x 4 cells: collects facets that may be closest to any, or whose leaf its parts may name.
 */
static void fill_parts(struct filling *f, const struct block *block, double facets)
{
    const double reach = cml_larger(facets + 2 * reach_of(block), CML_MOST_REACH + 1.7320509);
    double middle[3][CML_PLACES], at[3], lower[3], upper[3];
    place_of(f, block->middle, at);
    for (int k = 0; k < 3; k++) {
        lower[k] = at[k] - f->map->cell * reach;
        upper[k] = at[k] + f->map->cell * reach;
    }
    f->collected = 0;
    cml_boxtree_touching(f->tree, lower, upper, collect, f);
    middles_of_parts(f, block, middle);
    f->level->squares(f->flat, f->found, f->collected, middle, f->square);
    for (int i = 0; i < CML_PLACES; i++) {
        struct block part;
        if (part_of(f->map, block, i, &part)) fill_part(f, &part, i);
    }
}

/* By halves, down to blocks that are far from the surface, or to cells. Where facets are large, blocks of 4
 * cells find all those that are close at once. */
static void fill_block(struct filling *f, struct block block)
{
    const double facets = closest_facet(f, block.middle, &block.facet),
                 safe = with_outer_plane(f, block.middle, facets);
    if (is_far(&block, safe)) {
        set_far_block(f->map, &block, safe);
        return;
    }
    if (block.level == 2 && f->map->names) {
        fill_parts(f, &block, facets);
        return;
    }
    for (int i = 0; i < CML_PLACES; i++) {
        struct block part;
        if (part_of(f->map, &block, i, &part)) fill_block(f, part);
    }
}

/* Edge of an equilateral triangle of the mean area, cm. */
static double mean_edge(const struct cml_mesh *mesh)
{
    double sum = 0, normal[3];
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        const uint32_t *v = mesh->triangle[i];
        cml_vec3_area(mesh->vertex[v[0]], mesh->vertex[v[1]], mesh->vertex[v[2]], normal);
        sum += cml_vec3_length(normal);
    }
    return sqrt(1.1547005 * sum / (double)mesh->num_triangles);
}

/* The box and a little more, in cells as small as they pay and memory allows. Returns how many. */
static size_t lay_out(const struct cml_mesh *mesh, double edge, double most, struct cml_safe_map *map)
{
    double longest = 0, cells = INFINITY;
    for (int k = 0; k < 3; k++) longest = fmax(longest, mesh->upper[k] - mesh->lower[k]);
    map->cell = fmax(longest / MOST_ALONG, edge / CELLS_PER_EDGE);
    for (; cells > most; map->cell *= cells > most ? 1.1 : 1) {
        cells = 1;
        for (int k = 0; k < 3; k++) {
            map->n[k] = (int)ceil((mesh->upper[k] - mesh->lower[k]) / map->cell) + 2 * AROUND;
            map->blocks[k] = (map->n[k] + 1) / 2;
            cells *= map->n[k];
        }
    }
    for (int k = 0; k < 3; k++) {
        map->corner[k] = 0.5 * (mesh->lower[k] + mesh->upper[k] - map->n[k] * map->cell);
        map->from[k] = (float)map->corner[k];
    }
    map->per_cell = (float)(1 / map->cell);
    return (size_t)cells;
}

static size_t blocks_of(const struct cml_safe_map *map)
{
    return (size_t)map->blocks[0] * (size_t)map->blocks[1] * (size_t)map->blocks[2];
}

static void find_facets(struct filling *f, const struct cml_facet_tree *tree)
{
    for (int i = 0; i < (int)f->centred->mesh.num_triangles; i++) {
        const double *corner[3];
        for (int k = 0; k < 3; k++) corner[k] = cml_centred_corner(f->centred, i, k);
        cml_flat_facet_of(corner, &f->flat[i]);
    }
    for (uint32_t i = 0; i < tree->leaves; i++)
        for (int k = 0; k < CML_GROUP; k++)
            if (tree->leaf[i].facet[k] != CML_TREE_NO_FACET) f->leaf[tree->leaf[i].facet[k]] = i;
}

static void fill(struct filling *f)
{
    struct block whole = {.level = 2};
    for (int k = 0; k < 3; k++)
        while (1 << whole.level < f->map->n[k]) whole.level++;
    for (int k = 0; k < 3; k++) whole.middle[k] = 0.5 * (1 << whole.level);
    fill_block(f, whole);
}

static cml_status make_filling(struct filling *f, const struct cml_facet_tree *tree, struct cml_error *err)
{
    const struct cml_mesh *mesh = &f->centred->mesh;
    const size_t count = mesh->num_triangles;
    CML_TRY(cml_boxtree_create((const double(*)[3])mesh->vertex, (const uint32_t(*)[3])mesh->triangle, count,
                               &f->tree, err));
    f->flat = cml_arrays_add(&f->arrays, count, sizeof *f->flat);
    f->square = cml_arrays_add(&f->arrays, 2 * count, sizeof *f->square);
    f->leaf = cml_arrays_add(&f->arrays, count, sizeof *f->leaf);
    f->found = cml_arrays_add(&f->arrays, count, sizeof *f->found);
    f->closest = cml_arrays_add(&f->arrays, count, sizeof *f->closest);
    CML_TRY(cml_arrays_check(&f->arrays, "facets", err));
    find_facets(f, tree);
    const struct cml_tree_level *levels[CML_TREE_LEVELS];
    cml_tree_levels(levels);
    f->level = levels[0];
    return CML_OK;
}

static void clear_filling(struct filling *f)
{
    cml_arrays_free(&f->arrays);
    if (f->tree) cml_boxtree_free(f->tree);
}

cml_status cml_safe_map_create(const struct cml_centred_mesh *centred, const struct cml_facet_tree *tree,
                               double bytes, struct cml_safe_map *map, struct cml_error *err)
{
    struct filling f = {.centred = centred, .map = map};
    const double edge = mean_edge(&centred->mesh);
    *map = (struct cml_safe_map){.safe = NULL};
    const size_t cells =
        lay_out(&centred->mesh, edge, bytes / (sizeof *map->safe + sizeof *map->names / 8.0), map);
    cml_status status = make_filling(&f, tree, err);
    map->safe = status == CML_OK ? malloc(cells * sizeof *map->safe) : NULL;
    if (map->safe && edge > COARSE * map->cell) map->names = calloc(blocks_of(map), sizeof *map->names);
    if (map->safe)
        fill(&f);
    else if (status == CML_OK)
        status = cml_fail_memory(err, (double)cells * sizeof *map->safe, "safe distances");
    clear_filling(&f);
    return status;
}

void cml_safe_map_clear(struct cml_safe_map *map)
{
    free(map->safe);
    free(map->names);
    *map = (struct cml_safe_map){.safe = NULL};
}

double cml_safe_map_bytes(const struct cml_safe_map *map)
{
    const double names = map->names ? (double)(blocks_of(map) * sizeof *map->names) : 0;
    return (double)map->n[0] * map->n[1] * map->n[2] * (double)sizeof *map->safe + names;
}
