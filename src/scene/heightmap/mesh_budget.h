/* How many triangles one boundary may have. The one place where that is decided, before their memory is
 * taken: for tessellated heightfields, heightmaps and mesh files. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#define CML_MESH_MOST 0x1p26 /* triangles; more are refused whatever is asked for */

struct cml_mesh_budget {
    double most; /* triangles; 0: CML_MESH_MOST */
    /* Called before a mesh is made that is expected to take more than a second: a text without a line feed,
     * and the seconds. NULL: nobody is told. */
    void (*on_large)(void *context, const char *text, double seconds);
    void *context;
    const char *file; /* whose boundary it is, for messages; NULL: not known */
    int line;         /* 0: none */
    int boundary;
    int body; /* its number from 1; 0: a boundary's */
};

/* Triangles: 4e6, or fewer where these would fill more than a quarter of this machine's memory. For a
 * triangle 350 bytes are counted: at the peak, when the trees are built, 272 (heightmap), 309 to 335
 * (tessellation) and 337 (.obj) were measured, less the 15 MB of a program without meshes. */
double cml_mesh_budget_default(void);

/* CML_E_INPUT when a mesh of so many triangles is over the budget (NULL: CML_MESH_MOST): "FILE:LINE: boundary
 * B needs N triangles, M GiB (expected at most K, or REMEDY)". Else tells of a large one. */
CML_NODISCARD cml_status cml_mesh_budget_check(const struct cml_mesh_budget *budget, double triangles,
                                               const char *remedy, struct cml_error *err);
