/* All engines by name.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"

/* Returns the engine "cpu", "reference" or "opencl"; NULL for another name. */
const struct cml_engine *cml_engine_find(const char *name);
