/* SPDX-License-Identifier: MIT */
#include "unit/surface/mesh/mesh_walk_cases.h"
