/* SPDX-License-Identifier: MIT */
#include "input/mesh/polygons.h"

#include "base/array.h"

static const char what[] = "a mesh";

void cml_polygons_clear(struct cml_polygons *polygons)
{
    free(polygons->vertex);
    free(polygons->vertex_line);
    free(polygons->corner);
    free(polygons->face_size);
    free(polygons->face_line);
    *polygons = (struct cml_polygons){0};
}

/* Adds the line of element `count` to an array of lines, unless the file is binary. */
static cml_status add_line(int **lines, size_t count, int line, struct cml_error *err)
{
    if (line <= 0) return CML_OK;
    CML_TRY(cml_array_grow(lines, count, sizeof **lines, what, err));
    (*lines)[count] = line;
    return CML_OK;
}

cml_status cml_polygons_add_vertex(struct cml_polygons *polygons, const double vertex[3], int line,
                                   struct cml_error *err)
{
    const size_t count = polygons->num_vertices;
    CML_TRY(cml_array_grow(&polygons->vertex, count, sizeof *polygons->vertex, what, err));
    CML_TRY(add_line(&polygons->vertex_line, count, line, err));
    memcpy(polygons->vertex[count], vertex, sizeof *polygons->vertex);
    polygons->num_vertices++;
    return CML_OK;
}

cml_status cml_polygons_add_face(struct cml_polygons *polygons, uint32_t size, int line,
                                 struct cml_error *err)
{
    const size_t count = polygons->num_faces;
    CML_TRY(cml_array_grow(&polygons->face_size, count, sizeof *polygons->face_size, what, err));
    CML_TRY(add_line(&polygons->face_line, count, line, err));
    polygons->face_size[count] = size;
    polygons->num_faces++;
    return CML_OK;
}

cml_status cml_polygons_add_corner(struct cml_polygons *polygons, uint32_t vertex, struct cml_error *err)
{
    CML_TRY(cml_array_grow(&polygons->corner, polygons->num_corners, sizeof *polygons->corner, what, err));
    polygons->corner[polygons->num_corners++] = vertex;
    return CML_OK;
}
