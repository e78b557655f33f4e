/* SPDX-License-Identifier: MIT */
#include "vector/processor.h"

/* Returns the x86-64 level of this processor: 4 with AVX-512, 3 with AVX2, else 0. The vector loops are
 * compiled once for each level, and the highest one that the processor runs is used. */
int cml_processor_level(void)
{
#ifdef CML_X86_LEVELS
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") || !__builtin_cpu_supports("bmi2"))
        return 0;
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                   __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                   __builtin_cpu_supports("avx512vl")
               ? 4
               : 3;
#else
    return 0;
#endif
}
