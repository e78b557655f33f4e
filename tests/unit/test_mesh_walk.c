/* SPDX-License-Identifier: MIT */
#include "mesh_walk_cases.h"
