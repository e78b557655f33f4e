/* Fuzzes .ply files (fuzz_mesh.h). SPDX-License-Identifier: MIT */
#define FUZZ_MESH "mesh.ply"
#include "fuzz/fuzz_mesh.h"
