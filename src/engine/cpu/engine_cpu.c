/* SPDX-License-Identifier: MIT */
#include "engine/cpu/engine_cpu.h"

#include <stddef.h>

extern const struct cml_engine cml_engine_cpu_base;
#ifdef CML_X86_LEVELS
extern const struct cml_engine cml_engine_cpu_v3, cml_engine_cpu_v4;

/* The levels of the x86-64 psABI, as far as our code can use them. */
static bool has_v3(void)
{
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
}

static bool has_v4(void)
{
    return has_v3() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
}
#endif

/* In the order in which they are preferred; the baseline runs everywhere. */
int cml_cpu_levels(struct cml_cpu_level levels[CML_CPU_LEVELS])
{
    int count = 0;
#ifdef CML_X86_LEVELS
    if (has_v4()) levels[count++] = (struct cml_cpu_level){"x86-64-v4", &cml_engine_cpu_v4};
    if (has_v3()) levels[count++] = (struct cml_cpu_level){"x86-64-v3", &cml_engine_cpu_v3};
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
