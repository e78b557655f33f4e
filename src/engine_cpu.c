/* Which of the CPU engine's levels this machine can run: the best one is `cpu`.
 * SPDX-License-Identifier: MIT */
#include "engine.h"

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

static const struct cml_engine *best(void)
{
    struct cml_cpu_level levels[CML_CPU_LEVELS];
    cml_cpu_levels(levels);
    return levels[0].engine;
}

static cml_status open_best(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                            const struct cml_engine_options *options, void **self, struct cml_error *err)
{
    return best()->open(scene, surfaces, options, self, err);
}

static cml_status run_best(void *self, uint64_t first, uint64_t count, struct cml_tally *tally,
                           struct cml_error *err)
{
    return best()->run(self, first, count, tally, err);
}

static cml_status trace_best(void *self, uint64_t index, cml_trace_function *on_event, void *context,
                             struct cml_fate_record *record, struct cml_error *err)
{
    return best()->trace(self, index, on_event, context, record, err);
}

static cml_status fates_of_best(void *self, uint64_t first, uint64_t count, struct cml_fate_record *records,
                                struct cml_error *err)
{
    return best()->fates(self, first, count, records, err);
}

static int threads_of_best(const void *self)
{
    return best()->threads(self);
}

static void close_best(void *self)
{
    best()->close(self);
}

const struct cml_engine cml_engine_cpu = {
    .name = "cpu",
    .description = "single precision, bundles of packets in vector loops, OpenMP threads",
    .open = open_best,
    .run = run_best,
    .trace = trace_best,
    .fates = fates_of_best,
    .threads = threads_of_best,
    .close = close_best,
};
