/* SPDX-License-Identifier: MIT */
#include "scene/checksum.h"

#include <zlib.h>

/* Adds numbers to a checksum, in which zero has one sign. */
static uLong add_numbers(uLong sum, const double *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const float number = (float)numbers[i] + 0.0f;
        sum = crc32_z(sum, (const Bytef *)&number, sizeof number);
    }
    return sum;
}

static uLong add_number(uLong sum, double number)
{
    return add_numbers(sum, &number, 1);
}

static uLong add_radial(uLong sum, const struct cml_radial *radial)
{
    sum = add_numbers(sum, radial->r, (size_t)radial->n);
    return add_numbers(sum, radial->h, (size_t)radial->n);
}

static uLong add_tile(uLong sum, const struct cml_heightmap *tile, enum cml_normals normals)
{
    const double place[] = {tile->nx, tile->ny, tile->x0, tile->y0, tile->dx, tile->dy, normals};
    sum = add_numbers(sum, place, sizeof place / sizeof *place);
    return add_numbers(sum, tile->h, (size_t)tile->nx * (size_t)tile->ny);
}

static uLong add_mesh(uLong sum, const struct cml_mesh *mesh)
{
    if (mesh->num_triangles == 0) return sum;
    sum = add_number(sum, mesh->normals);
    sum = add_numbers(sum, mesh->vertex[0], 3 * mesh->num_vertices);
    return crc32_z(sum, (const Bytef *)mesh->triangle, mesh->num_triangles * sizeof *mesh->triangle);
}

uint32_t cml_mesh_checksum(const struct cml_mesh *mesh)
{
    return (uint32_t)add_mesh(0, mesh);
}

uint32_t cml_boundary_checksum(const struct cml_boundary *boundary)
{
    switch (boundary->form) {
    case CML_FORM_RADIAL:
        return (uint32_t)add_radial(0, &boundary->radial);
    case CML_FORM_TILE:
        return (uint32_t)add_tile(0, &boundary->tile, boundary->tile_normals);
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
