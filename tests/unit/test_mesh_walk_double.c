/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "mesh_walk_cases.h"
