/* Strict scan of the text of an OBJ file. It refuses, with line numbers, mistakes that tinyobjloader would
 * accept, reads the coordinates, and leaves only plain `v` and `f` lines in the text.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "input/mesh/polygons.h"

/* Returns the number of triangles that the faces of the text become, in one pass without memory. A face with
 * mistakes, which the scan refuses later, may count as any number. */
size_t cml_obj_count(const struct cml_text *text);

/* Scans from the text's cursor to its end: adds vertices, sizes of faces and num_corners to *scan, and turns
 * everything but vertices and faces in text->data into blanks. Numbers above the number of vertices are not
 * refused here, because a face may stand before its vertices. The caller clears *scan in any case. */
CML_NODISCARD cml_status cml_obj_scan_text(struct cml_text *text, struct cml_polygons *scan,
                                           struct cml_error *err);
