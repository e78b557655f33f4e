/* The importance of light at a place for a detector: the share of isotropic light there that leaves where the
 * detector looks. Computed with the diffusion equation, which is its own adjoint, in finite volumes of rings
 * and depths [Haskell and others: Boundary conditions for the diffusion equation in radiative transfer, J.
 * Opt. Soc. Am. A 11, 2727 (1994)].
 *
 *        detector
 *          ====
 *     |  |   |     |         |    rings about the middle of the detector
 *     +--+---+-----+---------+
 *     |  |   |     |         |    pieces of layers
 *     +--+---+-----+---------+
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* A ring on the upper or lower face; radii about its middle in cm. */
struct cml_seen_ring {
    bool below;
    double inner, outer;
};

/* Rings on one face that share no place and have one middle; item[count]. */
struct cml_seen_rings {
    struct cml_seen_ring *item;
    int count;
};

/* Computes value[rings][cells]: the importance by ring and depth. Ring i begins at the radius reach (i /
 * rings)^2 about the middle of `seen`; `depth`, at most that of all layers, is cut into equal cells. media:
 * [layers + 2], with planes between them. The diffusion equation knows no directions, and is wrong within a
 * transport mean free path: good enough for weight windows. CML_E_INPUT: out of memory. */
CML_NODISCARD cml_status cml_importance_of_place(const struct cml_medium_def *media, int layers,
                                                 struct cml_seen_rings seen, double reach, double depth,
                                                 int rings, int cells, double *value, struct cml_error *err);
