/* How the facets of a represented boundary are drawn (surface_facets.h says what they are).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/surface.h"
#include "output/files/vtk.h"

/* The facets but the last one, of a surface that is no plane, as faces in the scene's coordinates (z down);
 * for each facet `per_facet` of them one behind the other, because a ring is drawn as quadrangles. The caller
 * frees what they point to. */
CML_NODISCARD cml_status cml_report_faces(const struct cml_surface_def *def, struct cml_faces *faces,
                                          size_t *per_facet, struct cml_error *err);
