/* Which body lies in which, and whether any two, or a body and a boundary, cross or touch.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* For readers: fills `host` of every body, from geometry. Bodies of one layer must not cross or touch each
 * other, nor themselves. Spheres against spheres, cylinders and triangles, and meshes against meshes, to
 * rounding; cylinders against cylinders and triangles to a thousandth of the radius. CML_E_INPUT: "FILE:LINE:
 * body 2 meets body 1 (line N) at (x y z) cm". */
CML_NODISCARD cml_status cml_scene_place_bodies(struct cml_scene *scene, struct cml_error *err);

/* Bodies must lie inside their layer, and not touch its boundaries. CML_E_INPUT: "FILE:LINE: body 1 meets
 * boundary 0 at (x y z) cm", or "lies outside of layer 1". Cylinders against heightfields and meshes as the
 * prisms of 512 sides around them. */
CML_NODISCARD cml_status cml_scene_check_bodies(const struct cml_scene *scene, struct cml_error *err);

/* All that a reader leaves to its caller, as it costs time: cml_scene_check_steepness,
 * cml_scene_check_overlap, then cml_scene_check_bodies. Only a scene that has passed may fly. */
CML_NODISCARD cml_status cml_scene_check_shapes(const struct cml_scene *scene, struct cml_error *err);
