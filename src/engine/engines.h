/* All engines by name. SPDX-License-Identifier: MIT */
#ifndef CML_ENGINES_H
#define CML_ENGINES_H

#include "engine/engine.h"

/* "cpu", "reference" or "opencl"; NULL when there is none of that name. */
const struct cml_engine *cml_engine_find(const char *name);

#endif
