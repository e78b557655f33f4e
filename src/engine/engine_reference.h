/* The engine `reference`: double, one packet at a time, one thread. The oracle for the others.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"

extern const struct cml_engine cml_engine_reference;
