/* The strict scan of an OBJ text: refuses with line numbers what tinyobjloader would let pass, reads the
 * coordinates, and leaves a text of nothing but plain `v` and `f` lines. SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"

struct cml_obj_scan {
    size_t num_vertices, num_faces;
    size_t num_corners;  /* of all faces together */
    double (*vertex)[3]; /* [num_vertices] as in the file */
    int *vertex_line;    /* [num_vertices] */
    uint32_t *face_size; /* [num_faces] corners */
    int *face_line;      /* [num_faces] */
};

/* How many triangles the faces of the text become, in one pass without memory. Faces with mistakes, which the
 * scan refuses, may count as any number. */
size_t cml_obj_count(const struct cml_text *text);

/* Scans from the text's cursor to its end and blanks everything but vertices and faces in text->data. Vertex
 * numbers above the number of vertices are not refused here, because a face may stand before its vertices.
 * Clear *scan in any case. */
CML_NODISCARD cml_status cml_obj_scan_text(struct cml_text *text, struct cml_obj_scan *scan,
                                           struct cml_error *err);

void cml_obj_scan_clear(struct cml_obj_scan *scan);
