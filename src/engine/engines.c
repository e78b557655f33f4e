/* SPDX-License-Identifier: MIT */
#include "engine/engines.h"

#include "engine/cpu/engine_cpu.h"
#include "engine/opencl/engine_opencl.h"
#include "engine/engine_reference.h"

#include <string.h>

/* Only this function names every engine, so a new engine is added here. */
const struct cml_engine *cml_engine_find(const char *name)
{
    const struct cml_engine *const engines[] = {cml_engine_cpu(), &cml_engine_reference, &cml_engine_opencl};
    for (size_t i = 0; i < sizeof engines / sizeof *engines; i++)
        if (strcmp(engines[i]->name, name) == 0) return engines[i];
    return NULL;
}
