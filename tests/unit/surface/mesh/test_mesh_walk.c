/* Runs the cases of mesh_walk_cases.h in single precision. SPDX-License-Identifier: MIT */
#include "unit/surface/mesh/mesh_walk_cases.h"
