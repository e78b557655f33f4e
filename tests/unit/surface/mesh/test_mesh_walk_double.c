/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/surface/mesh/mesh_walk_cases.h"
