/* Reader and writer of Wavefront OBJ files. tinyobjloader parses the faces. It would turn `nan` and `0,0`
 * into 0, and keep faces whose indices are out of range; a strict scan of the text (obj_scan.h) refuses these
 * first, with line numbers. SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "geometry/mesh.h"
#include "input/mesh/polygons.h"
#include "scene/heightmap/mesh_budget.h"

/* Adds the polygons of a text to *polygons, which the caller clears in any case. Changes the text.
 * CML_E_INPUT: refused, with file and line, or over the budget, which is checked first. */
CML_NODISCARD cml_status cml_obj_read(struct cml_text *text, const struct cml_mesh_budget *budget,
                                      struct cml_polygons *polygons, struct cml_error *err);

/* Writes a mesh as OBJ, heights up (Z_obj = -z), with 17 digits: cml_mesh_file_read gives the same
 * doubles back.
 * comment: written above, each line behind a '#'; NULL: none. Atomic (base/atomic_file.h). CML_E_IO. */
CML_NODISCARD cml_status cml_obj_write(const char *path, const struct cml_mesh *mesh, const char *comment,
                                       struct cml_error *err);
