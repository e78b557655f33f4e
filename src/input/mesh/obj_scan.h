/* Strict scan of the text of an OBJ file. It refuses, with line numbers, mistakes that tinyobjloader would
 * accept, reads the coordinates, and leaves only plain `v` and `f` lines in the text.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"

struct cml_obj_scan {
    size_t num_vertices, num_faces;
    size_t num_corners;  /* corners of all faces together */
    double (*vertex)[3]; /* [num_vertices] coordinates as in the file */
    int *vertex_line;    /* [num_vertices] lines of the file */
    uint32_t *face_size; /* [num_faces] corners of each face */
    int *face_line;      /* [num_faces] lines of the file */
};

/* Returns the number of triangles that the faces of the text become, in one pass without memory. A face with
 * mistakes, which the scan refuses later, may count as any number. */
size_t cml_obj_count(const struct cml_text *text);

/* Scans from the text's cursor to its end, and turns everything but vertices and faces in text->data into
 * blanks. Numbers above the number of vertices are not refused here, because a face may stand before its
 * vertices. The caller clears *scan in any case. */
CML_NODISCARD cml_status cml_obj_scan_text(struct cml_text *text, struct cml_obj_scan *scan,
                                           struct cml_error *err);

void cml_obj_scan_clear(struct cml_obj_scan *scan);
