/* Fuzzes .obj files (fuzz_mesh.h). SPDX-License-Identifier: MIT */
#define FUZZ_MESH "mesh.obj"
#include "fuzz/fuzz_mesh.h"
