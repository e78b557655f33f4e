/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#define ATLAS_FLY atlas_fly_double
#include "atlas_walk.h"
