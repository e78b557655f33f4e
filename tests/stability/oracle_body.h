/* An oracle that tells where a point lies relative to the bodies of a scene, without the program's ray code:
 * by distances to spheres and cylinders, and by counting surfaces above the point for meshes.
 *
 * Points are in the frame of the layer in which the body lies, but with x and y of the scene; cm.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "oracle.h"

/* All bodies of a scene. Columns over the x-y plane list the bodies above and below them. Borrows scene and
 * surfaces. */
struct oracle_bodies {
    const struct cml_scene *scene;
    const struct cml_body_surfaces *surfaces;
    struct cml_surface_def *def; /* [bodies] surfaces of the bodies that are meshes */
    struct oracle *mesh;         /* [bodies] oracles of the bodies that are meshes */
    bool *hosts;                 /* [media] true if any body lies in the medium */
    int size;                    /* number of columns along x, and along y */
    double corner[2], per_column[2];
    uint32_t *first, *entry; /* [size * size + 1] and [first[size * size]]: bodies of each column */
};

/* Makes the oracle of all bodies. Ends the process if memory runs out. */
void oracle_bodies_create(const struct cml_scene *scene, const struct cml_body_surfaces *surfaces,
                          struct oracle_bodies *bodies);
void oracle_bodies_free(struct oracle_bodies *bodies);

/* True if q lies inside body k (holds), or within `distance` of its surface (near). */
bool oracle_body_holds(const struct oracle_bodies *bodies, int k, const double q[3]);
bool oracle_body_near(const struct oracle_bodies *bodies, int k, const double q[3], double distance);

/* True if q lies inside the body that is this medium (anywhere, for a layer) and outside of all bodies
 * within that medium.
 *
 * A point within `distance` of a surface counts as on either side of it, or on neither side if `clearly`. */
bool oracle_bodies_allow(const struct oracle_bodies *bodies, int medium, const double q[3], double distance,
                         bool clearly);

/* Returns the medium of a point in layer `medium`: the layer, or the innermost body around q. */
int oracle_bodies_medium(const struct oracle_bodies *bodies, int medium, const double q[3]);

/* Returns a place on body k. Edges of a sphere are its circles in the planes of the axes, and its vertices
 * the poles on the axes. Edges of a cylinder are its rims and four lines along its side; its vertices are
 * where these meet the rims, and the middles of the ends. */
struct place oracle_body_place(const struct oracle_bodies *bodies, int k, enum place_kind kind,
                               struct dice *dice);
