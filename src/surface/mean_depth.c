/* Computes mean depths of boundaries and mean thicknesses of layers. SPDX-License-Identifier: MIT */
#include "surface/mean_depth.h"

#include "base/constants.h"

#include <math.h>
#include <stdlib.h>

/* Returns the volume between the cones and the plane around them, cm3; negative where the cones lie above the
 * plane. Between two rings the depth is linear in r. */
static double cones_volume(const struct cml_radial *radial)
{
    const double outer = radial->h[radial->n - 1];
    double volume = 0;
    for (int i = 0; i + 1 < radial->n; i++) {
        const double a = radial->r[i], b = radial->r[i + 1], at_a = outer - radial->h[i],
                     at_b = outer - radial->h[i + 1];
        volume += CML_PI / 3 * (b - a) * (at_a * (2 * a + b) + at_b * (a + 2 * b));
    }
    return volume;
}

/* Adds a mesh's area, seen from above, to *area (cm2), and the volume between the mesh and the plane at z to
 * *volume (cm3). The volume is a sum of prisms. A facet that faces down, as in an overhang, counts with a
 * negative area. */
static void add_sheet(const struct cml_mesh *mesh, double z, double *area, double *volume)
{
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const uint32_t *corner = mesh->triangle[t];
        const double *a = mesh->vertex[corner[0]], *b = mesh->vertex[corner[1]], *c = mesh->vertex[corner[2]];
        const double twice = (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1]);
        *area += twice / 2;
        *volume += twice / 2 * ((a[2] + b[2] + c[2]) / 3 - z);
    }
}

/* The part of a boundary that is not level. */
struct relief {
    bool endless;        /* true for a tile, which repeats for ever */
    double outer;        /* depth of the plane around it, cm; for a tile the zero of its heights */
    double area, volume; /* area: area of the relief, cm2; for a tile the area of one period. volume: volume
                            between the relief and the outer plane, cm3; negative above the plane */
};

/* Measures the part of boundary b that is not level. A boundary represented by a plane has no such part, and
 * gets the area 0. */
static cml_status find_relief(const struct cml_scene *scene, const struct cml_surface_set *set, int b,
                              const struct cml_surface_options *options, struct relief *relief,
                              struct cml_error *err)
{
    const struct cml_boundary *boundary = &scene->boundaries[b];
    const struct cml_surface_def *surface = &set->item[b];
    *relief = (struct relief){.outer = surface->depth};
    if (surface->kind == CML_SURFACE_PLANE) return CML_OK;
    relief->outer = boundary->z;
    if (boundary->form == CML_FORM_TILE) {
        relief->endless = true;
        relief->area = cml_tile_period(&boundary->tile, 0) * cml_tile_period(&boundary->tile, 1);
        relief->volume = -cml_tile_mean(&boundary->tile) * relief->area;
        return CML_OK;
    }
    const struct cml_radial *radial = &boundary->radial;
    const bool sheet = boundary->form == CML_FORM_MESH;
    const double outer = sheet ? boundary->mesh.z_border : -radial->h[radial->n - 1];
    relief->outer += outer;
    if (surface->kind != CML_SURFACE_MESH) {
        relief->area = CML_PI * radial->r[radial->n - 1] * radial->r[radial->n - 1];
        relief->volume = cones_volume(radial);
        return CML_OK;
    }
    CML_AT_END(cml_mesh_clear) struct cml_mesh mesh = {0};
    CML_TRY(cml_boundary_mesh(scene, b, options, &mesh, err));
    add_sheet(&mesh, outer, &relief->area, &relief->volume);
    return CML_OK;
}

/* Returns the boundary's mean depth over a level area, cm; over whole periods for a tile. */
static double depth_over(const struct relief *relief, double area)
{
    if (relief->endless) area = relief->area;
    return relief->outer + (relief->area > 0 ? relief->volume / area : 0);
}

cml_status cml_mean_depth(const struct cml_scene *scene, const struct cml_surface_set *set, int b,
                          const struct cml_surface_options *options, double area, double *depth,
                          struct cml_error *err)
{
    struct relief relief;
    CML_TRY(find_relief(scene, set, b, options, &relief, err));
    *depth = depth_over(&relief, area);
    return CML_OK;
}

cml_status cml_mean_shapes(const struct cml_scene *scene, const struct cml_surface_set *set,
                           const struct cml_surface_options *options, struct cml_mean_shapes *mean,
                           struct cml_error *err)
{
    const size_t n = (size_t)scene->num_layers + 1;
    *mean = (struct cml_mean_shapes){calloc(n, sizeof(double)), calloc(n, sizeof(double)),
                                     calloc(n, sizeof(double))};
    if (!mean->height || !mean->area || !mean->thickness)
        return cml_fail_memory(err, 3.0 * (double)(n * sizeof(double)), "mean heights");
    struct relief upper = {0}, lower;
    for (int b = 0; b <= scene->num_layers; b++, upper = lower) {
        CML_TRY(find_relief(scene, set, b, options, &lower, err));
        mean->area[b] = lower.area;
        mean->height[b] = scene->boundaries[b].z - depth_over(&lower, lower.area);
        const double area = fmax(upper.endless ? 0 : upper.area, lower.endless ? 0 : lower.area);
        if (b > 0) mean->thickness[b - 1] = depth_over(&lower, area) - depth_over(&upper, area);
    }
    return CML_OK;
}

void cml_mean_shapes_clear(struct cml_mean_shapes *mean)
{
    free(mean->height);
    free(mean->area);
    free(mean->thickness);
    *mean = (struct cml_mean_shapes){0};
}
