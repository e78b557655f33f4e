/* The faces of a mesh file, as its reader finds them: polygons over a list of vertices, in the file's order,
 * axes and units. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

/* Lines are numbers of lines of a text file. The arrays of lines stay NULL for a binary file. */
struct cml_polygons {
    size_t num_vertices, num_faces;
    size_t num_corners;  /* corners of all faces together */
    double (*vertex)[3]; /* [num_vertices] coordinates as in the file */
    int *vertex_line;    /* [num_vertices] */
    uint32_t *corner;    /* [num_corners] vertices of all faces, one face after the other */
    uint32_t *face_size; /* [num_faces] corners of each face, 3 or more */
    int *face_line;      /* [num_faces] */
};

/* Ways to keep within the budget of triangles, for messages. */
#define CML_POLYGONS_REMEDY "a coarser mesh or a larger --mesh-budget"

/* Frees the arrays and zeroes the structure. */
void cml_polygons_clear(struct cml_polygons *polygons);

/* Adds a vertex. line: 0 in a binary file. Fails if memory runs out. */
CML_NODISCARD cml_status cml_polygons_add_vertex(struct cml_polygons *polygons, const double vertex[3],
                                                 int line, struct cml_error *err);

/* Adds a face of `size` corners. Its corners are added to `corner` one by one, before or after. line: 0 in a
 * binary file. Fails if memory runs out. */
CML_NODISCARD cml_status cml_polygons_add_face(struct cml_polygons *polygons, uint32_t size, int line,
                                               struct cml_error *err);

/* Adds a corner. Fails if memory runs out. */
CML_NODISCARD cml_status cml_polygons_add_corner(struct cml_polygons *polygons, uint32_t vertex,
                                                 struct cml_error *err);
