/* The limit on how steep boundaries may be. Light that falls into a groove between walls of slope m turns by
 * 2 / m at every reflection, and comes out after at most pi m / 2 reflections. At slope 5000 these are 7900,
 * fewer than the 10000 in a row after which rule P9 takes light for trapped. SPDX-License-Identifier: MIT */
#include "geometry/vec3.h"
#include "scene/scene.h"

#include <math.h>

/* True if a height step over a horizontal run, both cm, exceeds the limit. Slopes that exceed it only by
 * rounding pass. */
static bool is_too_steep(double step, double run)
{
    return fabs(step) > (1 + 1e-9) * CML_STEEPEST * run;
}

/* Refuses boundary b, because it has a slope above CML_STEEPEST at the place `at`. */
static cml_status refuse(const struct cml_scene *scene, int b, double slope, const double at[2],
                         struct cml_error *err)
{
    const struct cml_boundary *boundary = &scene->boundaries[b];
    return cml_fail(
        err, CML_E_INPUT,
        "%s:%d: boundary %d%s%.400s: slope %g at x = %g, y = %g cm (expected at most %g: light that a "
        "steeper groove turns back would count as trapped)",
        scene->file, boundary->line, b, boundary->file ? ", " : "", boundary->file ? boundary->file : "",
        slope, at[0], at[1], CML_STEEPEST);
}

/* Refuses a radial heightfield with a step between two radii that is too steep for the proven bounds of
 * rounding. */
static cml_status check_radial(const struct cml_scene *scene, int b, struct cml_error *err)
{
    const struct cml_radial *radial = &scene->boundaries[b].radial;
    for (int i = 1; i < radial->n; i++) {
        const double step = radial->h[i] - radial->h[i - 1], run = radial->r[i] - radial->r[i - 1];
        if (is_too_steep(step, run))
            return refuse(scene, b, fabs(step) / run, (double[2]){radial->r[i - 1], 0}, err);
    }
    return CML_OK;
}

/* Checks every facet of a heightmap, and the height of any mesh against its width. Single facets of a mesh
 * may have any slope, because a pit has upright walls and a facet alone does not tell whether another one
 * faces it closely. */
static cml_status check_mesh(const struct cml_scene *scene, int b, struct cml_error *err)
{
    const struct cml_mesh *mesh = &scene->boundaries[b].mesh;
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const double *v[3];
        double area[3];
        for (int k = 0; k < 3; k++) v[k] = mesh->vertex[mesh->triangle[t][k]];
        for (int k = 0; k < 9; k++) {
            low[k % 3] = fmin(low[k % 3], v[k / 3][k % 3]);
            high[k % 3] = fmax(high[k % 3], v[k / 3][k % 3]);
        }
        cml_vec3_area(v[0], v[1], v[2], area);
        const double across = hypot(area[0], area[1]);
        if (scene->boundaries[b].map_notes.nx > 0 && is_too_steep(across, fabs(area[2])))
            return refuse(scene, b, across / fabs(area[2]), v[0], err);
    }
    const double rise = high[2] - low[2], width = fmax(high[0] - low[0], high[1] - low[1]);
    return is_too_steep(rise, width) ? refuse(scene, b, rise / width, low, err) : CML_OK;
}

/* Refuses a repeated heightmap with a step to the next sample in x or y that is too steep. */
static cml_status check_tile(const struct cml_scene *scene, int b, struct cml_error *err)
{
    const struct cml_heightmap *tile = &scene->boundaries[b].tile;
    for (int j = 0; j < tile->ny; j++)
        for (int i = 0; i < tile->nx; i++) {
            const double h = cml_tile_height(tile, i, j),
                         at[2] = {tile->x0 + i * tile->dx, tile->y0 + j * tile->dy};
            const double dx = cml_tile_height(tile, i + 1, j) - h, dy = cml_tile_height(tile, i, j + 1) - h;
            if (is_too_steep(dx, tile->dx)) return refuse(scene, b, fabs(dx) / tile->dx, at, err);
            if (is_too_steep(dy, tile->dy)) return refuse(scene, b, fabs(dy) / tile->dy, at, err);
        }
    return CML_OK;
}

cml_status cml_scene_check_steepness(const struct cml_scene *scene, struct cml_error *err)
{
    for (int b = 0; b <= scene->num_layers; b++) {
        const enum cml_boundary_form form = scene->boundaries[b].form;
        if (form == CML_FORM_RADIAL) CML_TRY(check_radial(scene, b, err));
        if (form == CML_FORM_MESH) CML_TRY(check_mesh(scene, b, err));
        if (form == CML_FORM_TILE) CML_TRY(check_tile(scene, b, err));
    }
    return CML_OK;
}
