/* How often a curved boundary is asked, and how often it is met: bench_asked SCENE.mci ... For the first run
 * of each scene, on one thread: steps of a photon (interactions and boundary events), rays asked of curved
 * boundaries per step (CML_COUNT_QUERIES; the other steps provably ended before them), and those that met
 * one. Prints CSV. SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 199309L
#define CML_HOOK_MET(met) (rays_met += (met) != 0)
#include "engine/cpu/bundle_hooks.h"

static long rays_met;

#define CML_LEVEL asked
#include "engine/cpu/engine_cpu_level.c"

#include "fly_scene.h"

static void reset(void)
{
    rays_met = 0;
}

static void report(const char *path, const struct bench_flight *flight)
{
    const uint64_t *count = flight->tally.count;
    const double steps = (double)(count[CML_COUNT_INTERACTIONS] + count[CML_COUNT_BOUNDARY_EVENTS]);
    printf("%s,%.2f,%.4f,%.4f\n", path, steps / (double)flight->photons,
           (double)count[CML_COUNT_QUERIES] / steps, (double)rays_met / steps);
}

int main(int argc, char **argv)
{
    const struct bench_count bench = {"bench_asked", "scene,steps,asked,met", reset, report};
    return bench_scenes(&bench, argc, argv);
}
