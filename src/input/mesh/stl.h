/* Reader of STL files, binary or text. An STL file lists facets with three corners each, and no indices:
 * equal corners are joined when the mesh is prepared. SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "input/mesh/polygons.h"
#include "scene/heightmap/mesh_budget.h"

/* Adds the facets of a file to *polygons, which the caller clears in any case. Normals and attributes are not
 * used. A file of 84 + 50 n bytes that says it has n facets is binary, whatever it begins with; another one
 * is text if it begins with the word solid and has no NUL byte. Changes the text. CML_E_INPUT: refused, with
 * line or byte, or over the budget, which is checked first. */
CML_NODISCARD cml_status cml_stl_read(struct cml_text *text, const struct cml_mesh_budget *budget,
                                      struct cml_polygons *polygons, struct cml_error *err);
