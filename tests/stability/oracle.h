/* Where a point is, told without any of the program's ray code: on which side of a boundary, and how near. In
 * double precision, by counting what lies above the point. SPDX-License-Identifier: MIT */
#pragma once

#include "lib/dice.h"

#include "oracle_grid.h"
#include "surface/surface.h"

/* One boundary, in its own frame but with x and y of the scene. Borrows the arrays of the surface. */
struct oracle {
    const struct cml_surface_def *def;
    struct oracle_grid grid; /* CML_SURFACE_MESH, a sheet or closed: then below it is inside */
    double middle[3];        /* of the mesh's coordinates */
    double period[2];        /* of a tile, about that middle, cm; 0: nothing is repeated */
    double highest, lowest;  /* z of its topmost and its deepest point; above and below nothing is asked */
};

/* Fails the program when memory runs out. */
void oracle_create(const struct cml_surface_def *def, struct oracle *oracle);
void oracle_free(struct oracle *oracle);

/* Whether q lies below the boundary. Exactly on it, either. */
bool oracle_below(const struct oracle *oracle, const double q[3]);

/* Whether q lies within `distance` of the boundary. */
bool oracle_near(const struct oracle *oracle, const double q[3], double distance);

/* A place on a boundary: a unit normal and a unit tangent of a face that has it (the tangent along the edge
 * or ridge where one was asked for), and the size of that face. */
enum place_kind { PLACE_FACE, PLACE_EDGE, PLACE_VERTEX };
struct place {
    double point[3], normal[3], tangent[3], size;
};
struct place oracle_place(const struct oracle *oracle, enum place_kind kind, struct dice *dice);
