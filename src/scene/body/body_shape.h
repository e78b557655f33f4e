/* The shapes of bodies: boxes, volumes, and meshes that stand for spheres and cylinders.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/body/convex.h"
#include "scene/scene.h"

/* "sphere", "cylinder", "mesh" */
const char *cml_body_form_name(enum cml_body_form form);

/* A sphere or cylinder as a convex set. */
struct cml_convex cml_body_convex(const struct cml_scene_body *body);

/* The smallest box around it, scene coordinates, cm. */
void cml_body_box(const struct cml_scene_body *body, double lower[3], double upper[3]);

/* A point of its surface, scene coordinates. */
void cml_body_point(const struct cml_scene_body *body, double point[3]);

/* cm^3, of a mesh that of its facets. */
double cml_body_volume(const struct cml_scene_body *body);

/* A closed mesh in scene coordinates, prepared, that stands for a sphere or cylinder; of a mesh a copy.
 * A sphere is an icosahedron whose edges are cut into n parts [geodesic polyhedron, 20 n^2 triangles], a
 * cylinder a prism of n sides; both are scaled so that they have the body's volume, and so are second order
 * in 1/n. around: as large instead that the body lies inside (cylinders only). n >= 3. CML_E_INPUT when
 * memory runs out. */
CML_NODISCARD cml_status cml_body_mesh(const struct cml_scene_body *body, int n, bool around,
                                       struct cml_mesh *mesh, struct cml_error *err);

/* The n with which no point of such a mesh is further off the body than this share of its radius. */
int cml_body_segments(enum cml_body_form form, double tolerance);
