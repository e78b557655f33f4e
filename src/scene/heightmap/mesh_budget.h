/* The limit on the number of triangles of one boundary. It is checked here only, before memory is taken, for
 * tessellated heightfields, heightmaps and mesh files. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#define CML_MESH_MOST 0x1p26 /* triangles; more are refused for any budget */

/* The triangles that a mesh may have, and whom to tell about a large one. */
struct cml_mesh_budget {
    double most; /* largest number of triangles; 0: CML_MESH_MOST */
    /* Function called before a mesh is made that should take more than a second. It gets a text without a
     * line feed, and the expected seconds. NULL: nobody is told. */
    void (*on_large)(void *context, const char *text, double seconds);
    void *context;
    double read;      /* bytes of the mesh's file, which stay in memory; 0: none */
    const char *file; /* file of the boundary, for messages; NULL: not known */
    int line;         /* line number in the file; 0: none */
    int boundary;
    int body; /* number of the body, from 1; 0: the mesh belongs to a boundary */
};

/* Returns the default budget in triangles: 4e6, or fewer if these would fill more than a quarter of this
 * machine's memory. A triangle counts 350 bytes. Measured at the peak, while trees are built, were 272
 * (heightmap), 309 to 335 (tessellation) and 337 bytes (.obj), without the 15 MB of a program without
 * meshes. A file counts besides with what it has above 50 bytes per triangle, as a text .stl does. */
double cml_mesh_budget_default(void);

/* Checks a number of triangles against the budget (NULL: CML_MESH_MOST), and announces a large mesh
 * (on_large). CML_E_INPUT over the budget: "FILE:LINE: boundary B needs N triangles, M GiB (expected at most
 * K, or REMEDY)". */
CML_NODISCARD cml_status cml_mesh_budget_check(const struct cml_mesh_budget *budget, double triangles,
                                               const char *remedy, struct cml_error *err);
