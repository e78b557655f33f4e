/* How busy the lanes of the CPU engine are: bench_busy SCENE.mci ... For the first run of each scene, on one
 * thread: what happens to a photon, whether it is flown in a lane at all (ballistic ones are only counted),
 * how many lanes go through the loops of a pass and through those of the planes for it, whether they have
 * something to do there or not, and what it takes. Prints CSV. SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 199309L
#include "bundle_pass.h"

static double launched, lanes_in_passes, lanes_at_planes;

#define cml_bundle_launch(b, start, absorbed, first, lanes)                                                  \
    (launched += __builtin_popcount(lanes), cml_bundle_launch(b, start, absorbed, first, lanes))
#include "bundle_launch.h"

/* The loops that each pass, and each round of planes, begins with. */
#define cml_bundle_draw(setup, b) (lanes_in_passes += (b)->lanes, cml_bundle_draw(setup, b))
#define cml_bundle_reach_planes(b) (lanes_at_planes += (b)->lanes, cml_bundle_reach_planes(b))

#define CML_LEVEL busy
#include "engine_cpu_level.c"

#include "mci.h"

#include <stdio.h>
#include <time.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* As many photons as take about half a second, counted from 0; their time in seconds. */
static cml_status fly(void *cpu, struct cml_tally *tally, uint64_t *photons, double *seconds,
                      struct cml_error *err)
{
    *seconds = 0;
    for (*photons = 10000; *seconds < 0.4; *photons *= 4) {
        cml_tally_zero(tally);
        launched = lanes_in_passes = lanes_at_planes = 0;
        const double begin = now();
        CML_TRY(cpu_run(cpu, 0, *photons, tally, err));
        *seconds = now() - begin;
        if (*seconds >= 0.4) break;
    }
    return CML_OK;
}

static void report(const char *path, const struct cml_tally *tally, uint64_t photons, double seconds)
{
    const double n = (double)photons;
    printf("%s,%.3f,%.2f,%.2f,%.2f,%.2f,%.1f\n", path, launched / n,
           (double)tally->count[CML_COUNT_INTERACTIONS] / n,
           (double)tally->count[CML_COUNT_BOUNDARY_EVENTS] / n, lanes_in_passes / n, lanes_at_planes / n,
           1e9 * seconds / n);
}

static cml_status measure(const char *path, struct cml_error *err)
{
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct cml_tally tally;
    const struct cml_surface_options how = {.force = CML_AS_AUTO, .tessellation = {.tolerance = 1e-3}};
    const struct cml_engine_options options = {.seed = 1, .threads = 1, .reentry = true, .absorption = true};
    uint64_t photons;
    double seconds;
    void *cpu;
    CML_TRY(cml_mci_read(path, &list, err));
    CML_TRY(cml_surfaces_create(&list.scenes[0], &how, &surfaces, err));
    const struct cml_grid grid = cml_engine_grid(&list.scenes[0], &surfaces, &options);
    CML_TRY(cml_tally_create(&grid, &tally, err));
    CML_TRY(cpu_open(&list.scenes[0], &surfaces, &options, &cpu, err));
    CML_TRY(fly(cpu, &tally, &photons, &seconds, err));
    report(path, &tally, photons, seconds);
    cpu_close(cpu);
    cml_tally_free(&tally);
    cml_surfaces_free(&surfaces);
    cml_scene_list_clear(&list);
    return CML_OK;
}

int main(int argc, char **argv)
{
    struct cml_error err;
    printf("scene,launched,interactions,boundary_events,lanes_in_passes,lanes_at_planes,ns\n");
    for (int i = 1; i < argc; i++) {
        if (measure(argv[i], &err) == CML_OK) continue;
        fprintf(stderr, "bench_busy: %s\n", err.text);
        return 2;
    }
    return 0;
}
