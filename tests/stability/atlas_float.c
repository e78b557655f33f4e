/* SPDX-License-Identifier: MIT */
#define ATLAS_FLY atlas_fly_float
#include "atlas_walk.h"
