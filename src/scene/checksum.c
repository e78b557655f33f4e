/* SPDX-License-Identifier: MIT */
#include "scene/checksum.h"

#include <zlib.h>

/* Adds numbers, rounded to single precision, to the checksum `sum`. Adding 0 turns -0 into +0, so that both
 * zeros count alike. */
static uLong add_numbers(uLong sum, const double *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const float number = (float)numbers[i] + 0.0f;
        sum = crc32_z(sum, (const Bytef *)&number, sizeof number);
    }
    return sum;
}

/* Returns the checksum of a repeated heightmap: sizes, place, kind of normals and heights. */
static uLong sum_tile(const struct cml_heightmap *tile, enum cml_normals normals)
{
    const double place[] = {tile->nx, tile->ny, tile->x0, tile->y0, tile->dx, tile->dy, normals};
    const uLong sum = add_numbers(0, place, sizeof place / sizeof *place);
    return add_numbers(sum, tile->h, (size_t)tile->nx * (size_t)tile->ny);
}

uint32_t cml_mesh_checksum(const struct cml_mesh *mesh)
{
    if (mesh->num_triangles == 0) return 0;
    uLong sum = add_numbers(0, (double[]){mesh->normals}, 1);
    sum = add_numbers(sum, mesh->vertex[0], 3 * mesh->num_vertices);
    return (uint32_t)crc32_z(sum, (const Bytef *)mesh->triangle,
                             mesh->num_triangles * sizeof *mesh->triangle);
}

uint32_t cml_boundary_checksum(const struct cml_boundary *boundary)
{
    const struct cml_radial *radial = &boundary->radial;
    const size_t n = (size_t)radial->n;
    switch (boundary->form) {
    case CML_FORM_RADIAL:
        return (uint32_t)add_numbers(add_numbers(0, radial->r, n), radial->h, n);
    case CML_FORM_TILE:
        return (uint32_t)sum_tile(&boundary->tile, boundary->tile_normals);
    case CML_FORM_MESH:
        return cml_mesh_checksum(&boundary->mesh);
    case CML_FORM_PLANE:
        break;
    }
    return 0;
}

uint32_t cml_beam_checksum(const struct cml_beam *beam)
{
    const size_t pixels = (size_t)beam->columns * (size_t)beam->rows, rows = (size_t)beam->light.rows;
    uLong sum = add_numbers(0, beam->pixel, pixels);
    sum = add_numbers(sum, beam->light.t, rows);
    return (uint32_t)add_numbers(sum, beam->light.intensity, rows);
}
