/* world.c in double precision, for the reference engine. SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "engine/world.c"
