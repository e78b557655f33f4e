/* The facets of a represented boundary: how many, how large, and how to draw them.
 * A facet is a triangle of a mesh or a ring of cones, in the order of the boundary's primitives, and the last
 * one is the outer plane. The facets of a plane are the pixels of the map, if there is one, and the last one
 * is what lies outside. SPDX-License-Identifier: MIT */
#ifndef CML_SURFACE_FACETS_H
#define CML_SURFACE_FACETS_H

#include "surface.h"
#include "vtk.h"

/* With the last one. */
size_t cml_surface_facets(const struct cml_surface_def *def, const struct cml_map_def *map);

/* cm2; infinite for the last one. */
double cml_surface_facet_area(const struct cml_surface_def *def, const struct cml_map_def *map, size_t facet);

/* The facets but the last one, of a surface that is no plane, as faces in the scene's coordinates (z down);
 * for each facet `per_facet` of them one behind the other, because a ring is drawn as quadrangles. Freed by
 * cml_surface_faces_free. */
CML_NODISCARD cml_status cml_surface_faces(const struct cml_surface_def *def, struct cml_faces *faces,
                                           size_t *per_facet, struct cml_error *err);
void cml_surface_faces_free(struct cml_faces *faces);

#endif
