/* An oracle that tells where a point is, without any of the program's ray code: on which side of a boundary,
 * and how near. It works in double precision, by counting surfaces above the point.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lib/dice.h"

#include "oracle_grid.h"
#include "surface/surface.h"

/* One boundary in its own frame, with x and y of the scene. Borrows the arrays of the surface. */
struct oracle {
    const struct cml_surface_def *def;
    struct oracle_grid
        grid;               /* for CML_SURFACE_MESH, a sheet or a closed mesh, for which below means inside */
    double middle[3];       /* middle of the mesh's coordinates [cm] */
    double period[2];       /* period of a tile about the middle [cm]; 0: nothing is repeated */
    double highest, lowest; /* z of the topmost and the deepest point; above and below, the answer needs no
                             * search */
};

/* Makes the oracle of a boundary. Ends the process if memory runs out. */
void oracle_create(const struct cml_surface_def *def, struct oracle *oracle);
void oracle_free(struct oracle *oracle);

/* True if q lies below the boundary. Exactly on the boundary, either answer is right. */
bool oracle_below(const struct oracle *oracle, const double q[3]);

/* True if q lies within `distance` of the boundary [cm]. */
bool oracle_near(const struct oracle *oracle, const double q[3], double distance);

/* A place on a boundary: the point, a unit normal and a unit tangent of a face there, and the size of that
 * face. For an edge or ridge, the tangent points along it. */
enum place_kind { PLACE_FACE, PLACE_EDGE, PLACE_VERTEX };
struct place {
    double point[3], normal[3], tangent[3], size;
};
struct place oracle_place(const struct oracle *oracle, enum place_kind kind, struct dice *dice);
