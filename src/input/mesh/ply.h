/* Reader of PLY files (polygon file format, Stanford): ascii, binary_little_endian and binary_big_endian.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "input/mesh/polygons.h"
#include "scene/heightmap/mesh_budget.h"

/* Adds the faces of a file to *polygons, which the caller clears in any case. Only x, y and z of the element
 * `vertex` and the list vertex_indices, or vertex_index, of the element `face` are used; all else is skipped.
 * Changes the text. CML_E_INPUT: refused, with line or byte, or over the budget, which is checked as soon as
 * the header is read. */
CML_NODISCARD cml_status cml_ply_read(struct cml_text *text, const struct cml_mesh_budget *budget,
                                      struct cml_polygons *polygons, struct cml_error *err);
