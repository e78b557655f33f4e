/* Where a point is to the bodies of a scene, told without the program's ray code: by distances to spheres and
 * cylinders, by counting what lies above the point for meshes. Points are in the frame of the layer that the
 * body lies in, but with x and y of the scene; cm. SPDX-License-Identifier: MIT */
#pragma once

#include "oracle.h"

/* Columns over the x-y plane know the bodies above and below them. Borrows scene and surfaces. */
struct oracle_bodies {
    const struct cml_scene *scene;
    const struct cml_body_surfaces *surfaces;
    struct cml_surface_def *def; /* [bodies] of those that are meshes */
    struct oracle *mesh;         /* [bodies] likewise */
    bool *hosts;                 /* [media]: whether any body lies in it */
    int size;                    /* columns along x and along y */
    double corner[2], per_column[2];
    uint32_t *first, *entry; /* [size * size + 1], [first[size * size]]: bodies */
};

/* Fails the program when memory runs out. */
void oracle_bodies_create(const struct cml_scene *scene, const struct cml_body_surfaces *surfaces,
                          struct oracle_bodies *bodies);
void oracle_bodies_free(struct oracle_bodies *bodies);

/* Whether q lies inside body k, and whether within `distance` of its surface. */
bool oracle_body_holds(const struct oracle_bodies *bodies, int k, const double q[3]);
bool oracle_body_near(const struct oracle_bodies *bodies, int k, const double q[3], double distance);

/* Whether q lies inside the body whose medium this is (of a layer: anywhere), and outside of all bodies that
 * lie in it. What is within `distance` of a surface may lie on either side of it, or when `clearly` on none.
 */
bool oracle_bodies_allow(const struct oracle_bodies *bodies, int medium, const double q[3], double distance,
                         bool clearly);

/* The medium of a point of layer `medium`: its own, or that of the innermost body around q. */
int oracle_bodies_medium(const struct oracle_bodies *bodies, int medium, const double q[3]);

/* A place of body k: on a sphere edges are the circles in the planes of the axes, and vertices its poles
 * along them; on a cylinder edges are its rims and four lines along its side, and vertices where these meet
 * the rims, and the middles of the ends. */
struct place oracle_body_place(const struct oracle_bodies *bodies, int k, enum place_kind kind,
                               struct dice *dice);
