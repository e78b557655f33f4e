/* All engines by name. SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"

/* "cpu", "reference" or "opencl"; NULL when there is none of that name. */
const struct cml_engine *cml_engine_find(const char *name);
