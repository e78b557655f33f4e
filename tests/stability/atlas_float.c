/* SPDX-License-Identifier: MIT */
#define ATLAS_PRECISION float
#include "atlas_walk.h"
