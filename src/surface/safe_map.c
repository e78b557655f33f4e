/* SPDX-License-Identifier: MIT */
#include "surface/safe_map.h"

#include "geometry/box_tree.h"
#include "geometry/footprint.h"
#include "geometry/vec3.h"
#include "surface/mesh/mesh_surface.h"

#include <math.h>
#include <stdlib.h>

#define CELLS_PER_EDGE 6    /* of a mean facet */
#define MOST_ALONG 64       /* cells along the longest side of the box, for a cache's sake */
#define AROUND 2            /* cells on every side of the box */
#define MOST_BYTES 16777216 /* and a quarter of what the tree of facets takes */
#define FAR 8               /* times a block's reach: there its middle speaks for all of its cells */

struct filling {
    const struct cml_mesh *mesh;
    struct cml_footprint *footprint; /* NULL: no outer plane */
    struct cml_boxtree *tree;
    double origin[3]; /* of the cells, in the mesh's coordinates, cm */
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

static double smaller(double a, double b)
{
    return a < b ? a : b;
}

/* Square of the distance from p to a facet: to its closest edge, or to its plane where p is over the inside.
 * Needles, whose plane rounding may turn, are never taken for further than their edges, which are close to
 * all of their inside. */
static double facet_square(const void *context, uint32_t i, const double p[3])
{
    const struct cml_mesh *mesh = context;
    const double *corner[3];
    double normal[3], from[3], least = INFINITY;
    bool inside = true;
    for (int k = 0; k < 3; k++) corner[k] = mesh->vertex[mesh->triangle[i][k]];
    cml_vec3_area(corner[0], corner[1], corner[2], normal);
    for (int k = 0; k < 3; k++) {
        double edge[3], inwards[3];
        cml_vec3_subtract(corner[(k + 1) % 3], corner[k], edge);
        cml_vec3_subtract(p, corner[k], from);
        cml_vec3_cross(normal, edge, inwards);
        inside = inside && cml_vec3_dot(from, inwards) >= 0;
        const double along = cml_vec3_dot(from, edge), square = cml_vec3_dot(edge, edge);
        cml_vec3_add_scaled(from, along > 0 ? -smaller(along / square, 1) : 0, edge, from);
        least = smaller(least, cml_vec3_dot(from, from));
    }
    const double height = cml_vec3_dot(from, normal), size = cml_vec3_dot(normal, normal);
    return inside && size > 0 ? smaller(height * height / size, least) : least;
}

/* From a place to the closest facet, in cells. */
static double closest_facet(const struct filling *f, const double p[3], uint32_t *facet)
{
    double at[3];
    cml_vec3_add_scaled(f->origin, f->map->cell, p, at);
    return sqrt(cml_boxtree_closest(f->tree, at, facet_square, f->mesh, facet)) / f->map->cell;
}

/* Beyond the border the outer plane may be closer. Inside of it the closest place of that plane is on the
 * border, which the facets have. */
static double with_outer_plane(const struct filling *f, const double p[3], double facets)
{
    double at[3];
    if (!f->footprint) return facets;
    cml_vec3_add_scaled(f->origin, f->map->cell, p, at);
    if (cml_footprint_contains(f->footprint, at[0], at[1])) return facets;
    return smaller(facets, fabs(at[2] - f->mesh->z_border) / f->map->cell);
}

/* All cells of a block, from the safe distance of its middle: another place is closer to the surface by at
 * most the way to it. Rounded down by more than double and float round. */
static void set_block(const struct cml_safe_map *map, const struct block *block, double safe)
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
                const size_t row = (size_t)z * (size_t)map->n[1] + (size_t)y;
                map->safe[row * (size_t)map->n[0] + (size_t)x] =
                    (float)fmax(0, (1 - 1e-6) * (safe - distance(cell, block->middle)));
            }
}

/* By halves, down to those that are far from the surface, or a cell. */
static void fill_block(const struct filling *f, struct block block)
{
    const double half = 0.5 * (1 << block.level), reach = 1.7320509 * (half - 0.5);
    for (int k = 0; k < 3; k++) {
        if (block.at[k] >= f->map->n[k]) return;
        block.middle[k] = block.at[k] + half;
    }
    const double facets = closest_facet(f, block.middle, &block.facet),
                 safe = with_outer_plane(f, block.middle, facets);
    if (safe >= FAR * reach) {
        set_block(f->map, &block, safe);
        return;
    }
    block.level--;
    for (int part = 0; part < 8; part++) {
        struct block next = block;
        for (int k = 0; k < 3; k++) next.at[k] += (part >> k & 1) << block.level;
        fill_block(f, next);
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
static size_t lay_out(const struct cml_mesh *mesh, const double middle[3], double most, double origin[3],
                      struct cml_safe_map *map)
{
    double longest = 0, cells = INFINITY;
    for (int k = 0; k < 3; k++) longest = fmax(longest, mesh->upper[k] - mesh->lower[k]);
    map->cell = fmax(longest / MOST_ALONG, mean_edge(mesh) / CELLS_PER_EDGE);
    for (; cells > most; map->cell *= cells > most ? 1.1 : 1) {
        cells = 1;
        for (int k = 0; k < 3; k++) {
            map->n[k] = (int)ceil((mesh->upper[k] - mesh->lower[k]) / map->cell) + 2 * AROUND;
            cells *= map->n[k];
        }
    }
    for (int k = 0; k < 3; k++) {
        origin[k] = 0.5 * (mesh->lower[k] + mesh->upper[k] - map->n[k] * map->cell);
        map->corner[k] = origin[k] + middle[k];
    }
    return (size_t)cells;
}

static void fill(const struct filling *f)
{
    struct block whole = {.level = 0};
    for (int k = 0; k < 3; k++)
        while (1 << whole.level < f->map->n[k]) whole.level++;
    fill_block(f, whole);
}

cml_status cml_safe_map_create(const struct cml_mesh_surface *surface, struct cml_safe_map *map,
                               struct cml_error *err)
{
    double middle[3];
    const struct cml_mesh *mesh = cml_mesh_surface_mesh(surface, middle);
    struct filling f = {.mesh = mesh, .map = map};
    *map = (struct cml_safe_map){.safe = NULL};
    const double bytes = MOST_BYTES + 0.25 * cml_mesh_surface_bytes(surface);
    const size_t cells = lay_out(mesh, middle, bytes / sizeof *map->safe, f.origin, map);
    cml_status status =
        cml_boxtree_create((const double(*)[3])mesh->vertex, (const uint32_t(*)[3])mesh->triangle,
                           mesh->num_triangles, &f.tree, err);
    if (status == CML_OK && !mesh->closed) status = cml_footprint_create(mesh, &f.footprint, err);
    map->safe = status == CML_OK ? malloc(cells * sizeof *map->safe) : NULL;
    if (map->safe)
        fill(&f);
    else if (status == CML_OK)
        status = cml_fail_memory(err, (double)cells * sizeof *map->safe, "safe distances");
    if (f.footprint) cml_footprint_free(f.footprint);
    if (f.tree) cml_boxtree_free(f.tree);
    return status;
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
