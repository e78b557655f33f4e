/* Fills a map of safe distances around a mesh that overhangs. SPDX-License-Identifier: MIT */
#include "surface/bounds/safe_map.h"

#include "geometry/box_tree.h"
#include "geometry/footprint.h"
#include "geometry/vec3.h"
#include "surface/tree/facet_distance_inl.h"

#include <stdlib.h>

#define CELLS_PER_EDGE 6 /* cells along the edge of a mean facet */
#define MOST_ALONG 64    /* cells along the longest side of the box, at most: a cache must hold the map */
#define AROUND 2         /* cells added on every side of the box */
/* A block gives its cells one safe distance, that of its middle, if the surface is at least FAR times the
 * block's reach away. */
#define FAR 8

struct filling {
    const struct cml_centred_mesh *centred;
    struct cml_flat_facet *flat; /* [num_triangles] the facets, for distances */
    struct cml_boxtree *tree;
    const struct cml_safe_map *map;
};

/* A cube of 2^level cells along an edge. */
struct block {
    int level, at[3]; /* number of cells along an edge is 2^level; first cell */
    double middle[3]; /* middle of the block, in cells */
    uint32_t facet;   /* facet closest to the middle */
};

/* Returns the distance between two places. */
static double distance(const double a[3], const double b[3])
{
    double way[3];
    cml_vec3_subtract(a, b, way);
    return cml_vec3_length(way);
}

/* Returns the square of the distance of facet i from p, cm2 (a cml_boxtree_square). */
static double facet_square(const void *context, uint32_t i, const double p[3])
{
    return cml_flat_square((const struct cml_flat_facet *)context + i, p[0], p[1], p[2]);
}

/* Converts a place of the map, in cells, to the centred frame, cm. */
static void place_of(const struct filling *f, const double p[3], double at[3])
{
    cml_vec3_add_scaled(f->map->corner, f->map->cell, p, at);
}

/* Returns the distance from a place to the closest facet, in cells. *facet: a guess of that facet; becomes
 * its number. */
static double closest_facet(const struct filling *f, const double p[3], uint32_t *facet)
{
    double at[3];
    place_of(f, p, at);
    return sqrt(cml_boxtree_closest(f->tree, at, facet_square, f->flat, facet)) / f->map->cell;
}

/* Returns the smaller of the distances to the facets and to the outer plane, in cells. Inside the border the
 * closest place of the outer plane is on the border, which belongs to facets, too. */
static double with_outer_plane(const struct filling *f, const double p[3], double facets)
{
    double at[3];
    if (!f->centred->footprint) return facets;
    place_of(f, p, at);
    const double plane = fabs(at[2] - f->centred->mesh.z_border) / f->map->cell;
    return plane < facets && !cml_footprint_contains(f->centred->footprint, at[0], at[1]) ? plane : facets;
}

/* Returns a distance rounded down by more than the rounding of double and float. */
static float rounded_down(double cells)
{
    return (float)fmax(0, (1 - 1e-6) * cells - 1e-9);
}

/* Sets the safe distance of a cell, rounded down. */
static void set_cell(const struct cml_safe_map *map, int x, int y, int z, double safe)
{
    map->safe[((size_t)z * (size_t)map->n[1] + (size_t)y) * (size_t)map->n[0] + (size_t)x] =
        rounded_down(safe);
}

/* Sets all cells of a block from the safe distance of its middle: at another place the surface is closer by
 * at most the distance between the two. */
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

/* Computes part i (0 to 7) of a block of more than one cell. Returns false if the part has no cells of the
 * map. */
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

/* Returns the largest distance from a block's middle to the middle of a cell in it, in cells. */
static double reach_of(const struct block *block)
{
    return 0.8660255 * ((1 << block->level) - 1);
}

/* True if the block is so far from the surface that the safe distance of its middle suffices for all of its
 * cells. */
static bool is_far(const struct block *block, double safe)
{
    return safe >= FAR * reach_of(block);
}

/* Fills a block of the map with safe distances: divides it until its parts are far from the surface, or
 * single cells. */
static void fill_block(struct filling *f, struct block block)
{
    const double facets = closest_facet(f, block.middle, &block.facet),
                 safe = with_outer_plane(f, block.middle, facets);
    if (is_far(&block, safe)) {
        set_far_block(f->map, &block, safe);
        return;
    }
    for (int i = 0; i < 8; i++) {
        struct block part;
        if (part_of(f->map, &block, i, &part)) fill_block(f, part);
    }
}

/* Returns the edge of an equilateral triangle of the mesh's mean facet area, cm. */
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

/* Chooses cells over the mesh's box and a little more, as small as pays and as memory allows. Returns their
 * number. */
static size_t lay_out(const struct cml_mesh *mesh, double edge, double most, struct cml_safe_map *map)
{
    double longest = 0, cells = INFINITY;
    for (int k = 0; k < 3; k++) longest = fmax(longest, mesh->upper[k] - mesh->lower[k]);
    map->cell = fmax(longest / MOST_ALONG, edge / CELLS_PER_EDGE);
    for (; cells > most; map->cell *= cells > most ? 1.1 : 1) {
        cells = 1;
        for (int k = 0; k < 3; k++) {
            map->n[k] = (int)ceil((mesh->upper[k] - mesh->lower[k]) / map->cell) + 2 * AROUND;
            cells *= map->n[k];
        }
    }
    for (int k = 0; k < 3; k++)
        map->corner[k] = 0.5 * (mesh->lower[k] + mesh->upper[k] - map->n[k] * map->cell);
    return (size_t)cells;
}

/* Computes for every facet the frame by which distances from it are found quickly. */
static void find_facets(struct filling *f)
{
    for (int i = 0; i < (int)f->centred->mesh.num_triangles; i++) {
        const double *corner[3];
        for (int k = 0; k < 3; k++) corner[k] = cml_centred_corner(f->centred, i, k);
        cml_flat_facet_of(corner, &f->flat[i]);
    }
}

/* Fills the map of safe distances. Begins with one block, a cube of 2^level cells along an edge, that
 * contains all cells of the map. */
static void fill(struct filling *f)
{
    struct block whole = {.level = 2};
    for (int k = 0; k < 3; k++)
        while (1 << whole.level < f->map->n[k]) whole.level++;
    for (int k = 0; k < 3; k++) whole.middle[k] = 0.5 * (1 << whole.level);
    fill_block(f, whole);
}

/* Makes the tree of boxes and the frames of facets. Returns CML_E_INPUT if memory runs out; clear_filling
 * frees them. */
static cml_status make_filling(struct filling *f, struct cml_error *err)
{
    const struct cml_mesh *mesh = &f->centred->mesh;
    const size_t count = mesh->num_triangles;
    CML_TRY(cml_boxtree_create((const double(*)[3])mesh->vertex, (const uint32_t(*)[3])mesh->triangle, count,
                               &f->tree, err));
    f->flat = malloc(count * sizeof *f->flat);
    if (!f->flat) return cml_fail_memory(err, (double)(count * sizeof *f->flat), "facets");
    find_facets(f);
    return CML_OK;
}

/* Frees what make_filling has made. */
static void clear_filling(struct filling *f)
{
    free(f->flat);
    cml_boxtree_free(f->tree);
}

cml_status cml_safe_map_create(const struct cml_centred_mesh *centred, double bytes, struct cml_safe_map *map,
                               struct cml_error *err)
{
    CML_AT_END(clear_filling) struct filling f = {.centred = centred, .map = map};
    const double edge = mean_edge(&centred->mesh);
    *map = (struct cml_safe_map){.safe = NULL};
    const size_t cells = lay_out(&centred->mesh, edge, bytes / sizeof *map->safe, map);
    CML_TRY(make_filling(&f, err));
    map->safe = malloc(cells * sizeof *map->safe);
    if (!map->safe) return cml_fail_memory(err, (double)cells * sizeof *map->safe, "safe distances");
    fill(&f);
    return CML_OK;
}

void cml_safe_map_clear(struct cml_safe_map *map)
{
    free(map->safe);
    *map = (struct cml_safe_map){.safe = NULL};
}

double cml_safe_map_bytes(const struct cml_safe_map *map)
{
    return (double)map->n[0] * map->n[1] * map->n[2] * (double)sizeof *map->safe;
}
