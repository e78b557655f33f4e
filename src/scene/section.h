/* The lines in which the plane y = 0 cuts the boundaries and bodies of a scene: what a picture of the scene
 * shows. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* Straight pieces in no order. */
struct cml_cut {
    size_t count;
    double (*piece)[4]; /* [count] x, z of one end, x, z of the other; cm, z down */
};

/* What the plane cuts of the boundary and of the plane in which it goes on, between x_low and x_high; pieces
 * may reach beyond these. CML_E_INPUT only when memory runs out; *cut is then cleared. */
CML_NODISCARD cml_status cml_section_cut(const struct cml_boundary *boundary, double x_low, double x_high,
                                         struct cml_cut *cut, struct cml_error *err);

/* Adds what the plane cuts of a closed mesh in scene coordinates. CML_E_INPUT only when memory runs out. */
CML_NODISCARD cml_status cml_section_add_body(const struct cml_mesh *mesh, struct cml_cut *cut,
                                              struct cml_error *err);

void cml_cut_clear(struct cml_cut *cut);
