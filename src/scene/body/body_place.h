/* Finds which body lies inside which, and refuses bodies that cross or touch each other or a boundary.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

struct cml_convex;
struct cml_sheet;

/* Finds the host of every body (member `host`) from geometry; for readers. Bodies of one layer must not cross
 * or touch each other, nor themselves. Spheres are compared with spheres, cylinders and triangles, and meshes
 * with meshes, to rounding. Cylinders are compared with cylinders and triangles to a thousandth of the
 * radius. CML_E_INPUT: "FILE:LINE: body 2 meets body 1 (line N) at (x y z) cm". */
CML_NODISCARD cml_status cml_scene_place_bodies(struct cml_scene *scene, struct cml_error *err);

/* Compares a sphere or cylinder, with the box from `lower` to `upper` about it, with the triangles of a
 * sheet. Returns the number of triangles that lie inside the sphere or cylinder; SIZE_MAX if one meets its
 * surface: then at the place `at`. */
size_t cml_compare_with_facets(const struct cml_sheet *sheet, const struct cml_convex *convex,
                               const double lower[3], const double upper[3], double at[3]);

/* Checks that bodies lie inside their layer and do not touch its boundaries. Cylinders are compared with
 * heightfields and meshes as the prisms of 512 sides around them. CML_E_INPUT: "FILE:LINE: body 1 meets
 * boundary 0 at (x y z) cm (expected it inside its layer)", or "lies above", "lies below" or "lies beyond" in
 * place of "meets". */
CML_NODISCARD cml_status cml_scene_check_bodies(const struct cml_scene *scene, struct cml_error *err);

/* Runs the checks that a reader leaves to its caller because they cost time: cml_scene_check_steepness,
 * cml_scene_check_overlap, then cml_scene_check_bodies. Only a scene that has passed may be simulated. */
CML_NODISCARD cml_status cml_scene_check_shapes(const struct cml_scene *scene, struct cml_error *err);
