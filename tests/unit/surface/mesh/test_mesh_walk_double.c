/* Runs the cases of mesh_walk_cases.h in double precision. SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/surface/mesh/mesh_walk_cases.h"
