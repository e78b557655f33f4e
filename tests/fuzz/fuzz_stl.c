/* Fuzzes .stl files (fuzz_mesh.h). SPDX-License-Identifier: MIT */
#define FUZZ_MESH "mesh.stl"
#include "fuzz/fuzz_mesh.h"
