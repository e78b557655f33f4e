/* Sections through boundaries. A vertex on the plane counts as one of y > 0, so that every triangle has no
 * edge or two edges that pass the plane. SPDX-License-Identifier: MIT */
#include "scene/section.h"

#include "base/array.h"

#include <math.h>
#include <stdlib.h>

/* Across a picture; more are not seen. */
enum { MOST_TILE_CELLS = 4096 };

void cml_cut_clear(struct cml_cut *cut)
{
    free(cut->piece);
    *cut = (struct cml_cut){0};
}

static cml_status add(struct cml_cut *cut, double x0, double z0, double x1, double z1, struct cml_error *err)
{
    CML_TRY(cml_array_grow(&cut->piece, cut->count, sizeof *cut->piece, "a section", err));
    double *piece = cut->piece[cut->count++];
    piece[0] = x0;
    piece[1] = z0;
    piece[2] = x1;
    piece[3] = z1;
    return CML_OK;
}

/* ---- a radial heightfield ---- */

static cml_status cut_radial(const struct cml_boundary *boundary, double x_low, double x_high,
                             struct cml_cut *cut, struct cml_error *err)
{
    const struct cml_radial *radial = &boundary->radial;
    const int last = radial->n - 1;
    const double z = boundary->z;
    for (int side = -1; side <= 1; side += 2) {
        const double end = side > 0 ? x_high : x_low;
        for (int i = 0; i < last; i++)
            CML_TRY(add(cut, side * radial->r[i], z - radial->h[i], side * radial->r[i + 1],
                        z - radial->h[i + 1], err));
        if (side * end > radial->r[last])
            CML_TRY(add(cut, side * radial->r[last], z - radial->h[last], end, z - radial->h[last], err));
    }
    return CML_OK;
}

/* ---- a mesh ---- */

/* Whether the edge passes the plane, and where: x, z. */
static bool passes(const double *a, const double *b, double point[2])
{
    if ((a[1] < 0) == (b[1] < 0)) return false;
    const double t = a[1] / (a[1] - b[1]);
    point[0] = a[0] + t * (b[0] - a[0]);
    point[1] = a[2] + t * (b[2] - a[2]);
    return true;
}

static cml_status cut_triangles(const struct cml_mesh *mesh, double z, struct cml_cut *cut,
                                struct cml_error *err)
{
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        double end[3][2];
        int ends = 0;
        for (int k = 0; k < 3; k++) {
            const double *a = mesh->vertex[mesh->triangle[t][k]];
            const double *b = mesh->vertex[mesh->triangle[t][(k + 1) % 3]];
            if (passes(a, b, end[ends])) ends++;
        }
        if (ends == 2) CML_TRY(add(cut, end[0][0], z + end[0][1], end[1][0], z + end[1][1], err));
    }
    return CML_OK;
}

/* The outer plane ends where the border passes, begins at the next passage, and so on: from x_low, which lies
 * outside, to x_high. x holds one number more than the border has edges. */
static cml_status cut_outside(const struct cml_boundary *boundary, double x_low, double x_high, double *x,
                              struct cml_cut *cut, struct cml_error *err)
{
    const struct cml_mesh *mesh = &boundary->mesh;
    const double z = cml_outer_depth(boundary);
    size_t passages = 0;
    for (size_t i = 0; i < mesh->num_border; i++) {
        double point[2];
        const double *a = mesh->vertex[mesh->border[i]];
        if (passes(a, mesh->vertex[mesh->border[(i + 1) % mesh->num_border]], point))
            x[passages++] = point[0];
    }
    qsort(x, passages, sizeof *x, cml_compare_doubles);
    x[passages] = x_high;
    double from = x_low;
    for (size_t i = 0; i <= passages; i += 2) {
        if (x[i] > from) CML_TRY(add(cut, from, z, x[i], z, err));
        if (i < passages) from = x[i + 1];
    }
    return CML_OK;
}

static cml_status cut_mesh(const struct cml_boundary *boundary, double x_low, double x_high,
                           struct cml_cut *cut, struct cml_error *err)
{
    double *x = malloc((boundary->mesh.num_border + 1) * sizeof *x);
    if (!x) return cml_fail_memory(err, 8.0 * (double)boundary->mesh.num_border, "a section");
    cml_status status = cut_triangles(&boundary->mesh, boundary->z, cut, err);
    if (status == CML_OK) status = cut_outside(boundary, x_low, x_high, x, cut, err);
    free(x);
    return status;
}

/* ---- a tile ---- */

/* Depth of the surface at a place in cells from the tile's first sample. */
static double tile_depth(const struct cml_boundary *boundary, double x, double y)
{
    const struct cml_heightmap *tile = &boundary->tile;
    const int64_t i = (int64_t)floor(x), j = (int64_t)floor(y);
    const double u = x - floor(x), v = y - floor(y);
    const double a = cml_tile_height(tile, i, j), b = cml_tile_height(tile, i + 1, j),
                 c = cml_tile_height(tile, i + 1, j + 1), d = cml_tile_height(tile, i, j + 1);
    double height;
    if (cml_tile_rises(tile, i, j))
        height = v < u ? a + u * (b - a) + v * (c - b) : a + v * (d - a) + u * (c - d);
    else
        height = u + v < 1 ? a + u * (b - a) + v * (d - a) : c + (1 - u) * (d - c) + (1 - v) * (b - c);
    return boundary->z - height;
}

/* Two pieces a cell, which meet on its diagonal; of very many cells some, each from end to end. */
static cml_status cut_tile(const struct cml_boundary *boundary, double x_low, double x_high,
                           struct cml_cut *cut, struct cml_error *err)
{
    const struct cml_heightmap *tile = &boundary->tile;
    const double y = -tile->y0 / tile->dy, v = y - floor(y);
    const int64_t j = (int64_t)floor(y), first = (int64_t)floor((x_low - tile->x0) / tile->dx),
                  last = (int64_t)floor((x_high - tile->x0) / tile->dx);
    const int64_t step = (last - first) / MOST_TILE_CELLS + 1;
    for (int64_t i = first; i <= last; i += step) {
        const double bend = step > 1 ? 0.5 * (double)step : cml_tile_rises(tile, i, j) ? v : 1 - v;
        const double cells[3] = {(double)i, (double)i + bend, (double)(i + step)};
        for (int k = 0; k < 2; k++)
            CML_TRY(add(cut, tile->x0 + cells[k] * tile->dx, tile_depth(boundary, cells[k], y),
                        tile->x0 + cells[k + 1] * tile->dx, tile_depth(boundary, cells[k + 1], y), err));
    }
    return CML_OK;
}

cml_status cml_section_add_body(const struct cml_mesh *mesh, struct cml_cut *cut, struct cml_error *err)
{
    return cut_triangles(mesh, 0, cut, err);
}

cml_status cml_section_cut(const struct cml_boundary *boundary, double x_low, double x_high,
                           struct cml_cut *cut, struct cml_error *err)
{
    *cut = (struct cml_cut){0};
    cml_status status = CML_OK;
    if (boundary->form == CML_FORM_MESH)
        status = cut_mesh(boundary, x_low, x_high, cut, err);
    else if (boundary->form == CML_FORM_TILE)
        status = cut_tile(boundary, x_low, x_high, cut, err);
    else if (boundary->form == CML_FORM_RADIAL)
        status = cut_radial(boundary, x_low, x_high, cut, err);
    else
        status = add(cut, x_low, boundary->z, x_high, boundary->z, err);
    if (status != CML_OK) cml_cut_clear(cut);
    return status;
}
