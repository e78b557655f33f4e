/* Compiles world.c, world_bodies.c, world_detectors.c and world_sources.c in double
 * precision, for the reference engine.
 * SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "engine/world.c"
#include "engine/world_bodies.c"
#include "engine/world_detectors.c"
#include "engine/world_sources.c"
