/* How busy the lanes of the CPU engine are: bench_busy SCENE.mci ... For the first run of each scene, on one
 * thread: what happens to a photon, whether it is flown in a lane at all (ballistic ones are only counted),
 * how many lanes go through the loops of a pass and through those of the planes for it, whether they have
 * something to do there or not, and what it takes. Prints CSV. SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 199309L
#define CML_HOOK_LANES(loop, lanes) (counted[loop] += (lanes))
#include "engine/cpu/bundle_hooks.h"

static double counted[CML_HOOK_LOOPS]; /* lanes, by the loop that they went through */

#define CML_LEVEL busy
#include "engine/cpu/engine_cpu_level.c"

#include "fly_scene.h"

static void reset(void)
{
    for (int loop = 0; loop < CML_HOOK_LOOPS; loop++) counted[loop] = 0;
}

static void report(const char *path, const struct bench_flight *flight)
{
    const double n = (double)flight->photons;
    const uint64_t *count = flight->tally.count;
    printf("%s,%.3f,%.2f,%.2f,%.2f,%.2f,%.1f\n", path, counted[CML_HOOK_LAUNCH] / n,
           (double)count[CML_COUNT_INTERACTIONS] / n, (double)count[CML_COUNT_BOUNDARY_EVENTS] / n,
           counted[CML_HOOK_PASS] / n, counted[CML_HOOK_PLANES] / n, 1e9 * flight->seconds / n);
}

int main(int argc, char **argv)
{
    const struct bench_count bench = {
        "bench_busy", "scene,launched,interactions,boundary_events,lanes_in_passes,lanes_at_planes,ns", reset,
        report};
    return bench_scenes(&bench, argc, argv);
}
