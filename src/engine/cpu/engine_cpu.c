/* SPDX-License-Identifier: MIT */
#include "engine/cpu/engine_cpu.h"

#include "vector/processor.h"

extern const struct cml_engine cml_engine_cpu_base;
#ifdef CML_X86_LEVELS
extern const struct cml_engine cml_engine_cpu_v3, cml_engine_cpu_v4;
#endif

/* The baseline runs on every machine. */
int cml_cpu_levels(struct cml_cpu_level levels[CML_CPU_LEVELS])
{
    int count = 0;
#ifdef CML_X86_LEVELS
    if (cml_processor_level() >= 4) levels[count++] = (struct cml_cpu_level){"x86-64-v4", &cml_engine_cpu_v4};
    if (cml_processor_level() >= 3) levels[count++] = (struct cml_cpu_level){"x86-64-v3", &cml_engine_cpu_v3};
#endif
    levels[count++] = (struct cml_cpu_level){"baseline", &cml_engine_cpu_base};
    return count;
}

const struct cml_engine *cml_engine_cpu(void)
{
    struct cml_cpu_level levels[CML_CPU_LEVELS];
    cml_cpu_levels(levels);
    return levels[0].engine;
}
