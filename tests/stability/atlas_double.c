/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#define ATLAS_PRECISION double
#include "atlas_walk.h"
