/* The geometry of bodies: bounding boxes, volumes, and meshes that stand for spheres and cylinders.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/body/convex.h"
#include "scene/scene.h"

/* Returns the word of a body's form: "sphere", "cylinder", "mesh". */
const char *cml_body_form_name(enum cml_body_form form);

/* Returns a sphere or cylinder as a convex set. */
struct cml_convex cml_body_convex(const struct cml_scene_body *body);

/* Returns the smallest box around a body, scene coordinates, cm. */
void cml_body_box(const struct cml_scene_body *body, double lower[3], double upper[3]);

/* Returns a point of the body's surface or, for a cylinder, the middle of its first end; scene coordinates,
 * cm. */
void cml_body_point(const struct cml_scene_body *body, double point[3]);

/* Returns the volume of a body, cm^3; for a mesh the volume inside its facets. */
double cml_body_volume(const struct cml_scene_body *body);

/* Makes a prepared, closed mesh that stands for a sphere or cylinder, or a copy of a mesh; scene coordinates.
 * A sphere becomes an icosahedron whose edges are cut into n parts [geodesic polyhedron, 20 n^2 triangles], a
 * cylinder a prism of n sides, n >= 3. Both are scaled to the body's volume, so their error is of second
 * order in 1/n. around (cylinders only): the prism is instead made so large that the cylinder lies inside it.
 * CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_body_mesh(const struct cml_scene_body *body, int n, bool around,
                                       struct cml_mesh *mesh, struct cml_error *err);

/* Returns the n for cml_body_mesh with which no point of the mesh is further from the body's surface than
 * `tolerance` times its radius; at most 1000. */
int cml_body_segments(enum cml_body_form form, double tolerance);
