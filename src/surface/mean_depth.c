/* SPDX-License-Identifier: MIT */
#include "surface/mean_depth.h"

/* Volume between the cones and the plane beyond them, cm3, below 0 above it: rings of a linear depth. */
static double cones_volume(const struct cml_radial *radial)
{
    const double pi = 3.14159265358979323846, outer = radial->h[radial->n - 1];
    double volume = 0;
    for (int i = 0; i + 1 < radial->n; i++) {
        const double a = radial->r[i], b = radial->r[i + 1], at_a = outer - radial->h[i],
                     at_b = outer - radial->h[i + 1];
        volume += pi / 3 * (b - a) * (at_a * (2 * a + b) + at_b * (a + 2 * b));
    }
    return volume;
}

/* The volume between a sheet and the plane at z: prisms, whose areas count below 0 where the sheet overhangs.
 */
static double sheet_volume(const struct cml_mesh *mesh, double z)
{
    double volume = 0;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const uint32_t *corner = mesh->triangle[t];
        const double *a = mesh->vertex[corner[0]], *b = mesh->vertex[corner[1]], *c = mesh->vertex[corner[2]];
        const double twice = (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1]);
        volume += twice / 2 * ((a[2] + b[2] + c[2]) / 3 - z);
    }
    return volume;
}

cml_status cml_mean_depth(const struct cml_scene *scene, const struct cml_surface_set *set, int b,
                          const struct cml_surface_options *options, double area, double *depth,
                          struct cml_error *err)
{
    const struct cml_boundary *boundary = &scene->boundaries[b];
    const struct cml_surface_def *surface = &set->item[b];
    const bool radial = boundary->form == CML_FORM_RADIAL, tile = boundary->form == CML_FORM_TILE;
    if (surface->kind == CML_SURFACE_PLANE) {
        *depth = surface->depth;
        return CML_OK;
    }
    const double outer = radial ? -boundary->radial.h[boundary->radial.n - 1]
                         : tile ? 0
                                : boundary->mesh.z_border;
    double volume = 0;
    if (surface->kind == CML_SURFACE_MESH) {
        struct cml_mesh mesh;
        CML_TRY(cml_boundary_mesh(scene, b, options, &mesh, err));
        volume = sheet_volume(&mesh, outer);
        cml_mesh_clear(&mesh);
    } else
        volume = cones_volume(&boundary->radial);
    if (tile) area = cml_tile_period(&boundary->tile, 0) * cml_tile_period(&boundary->tile, 1);
    *depth = boundary->z + outer + volume / area;
    return CML_OK;
}
