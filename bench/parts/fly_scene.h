/* Runs a scene of a bench on one thread, by an engine that is compiled with the bench: this file is included
 * after engine_cpu_level.c.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci.h"
#include "thread_clock.h"

#include <stdio.h>

struct bench_flight {
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct cml_tally tally;
    void *cpu;
    uint64_t photons;
    double seconds; /* seconds of all photons */
};

/* Opens the first run of a file. Boundaries that are not flat are represented as `force` says. */
static cml_status bench_open(const char *path, enum cml_surface_kind force, struct bench_flight *flight,
                             struct cml_error *err)
{
    const struct cml_surface_options how = {.force = force, .tessellation = {.tolerance = 1e-3}};
    const struct cml_engine_options options = {.seed = 1,
                                               .threads = 1,
                                               .lattice = true,
                                               .roulette = {0.003, 0.01},
                                               .reentry = true,
                                               .absorption = true};
    *flight = (struct bench_flight){0};
    CML_TRY(cml_mci_read(path, NULL, &flight->list, err));
    const struct cml_scene *scene = &flight->list.scenes[0];
    CML_TRY(cml_surfaces_create(scene, &how, &flight->surfaces, err));
    const struct cml_tally_grid grid = cml_engine_grid(scene, &flight->surfaces, &options);
    CML_TRY(cml_tally_create(&grid, &flight->tally, err));
    return cpu_open(scene, &flight->surfaces, &options, &flight->cpu, err);
}

static void bench_close(struct bench_flight *flight)
{
    cpu_close(flight->cpu);
    cml_tally_free(&flight->tally);
    cml_surfaces_free(&flight->surfaces);
    cml_scene_list_clear(&flight->list);
}

/* Flies as many photons, counted from 0, as take about half a second, into a clean tally. */
static cml_status bench_fly(struct bench_flight *flight, void (*reset)(void), struct cml_error *err)
{
    for (flight->photons = 10000;; flight->photons *= 4) {
        cml_tally_zero(&flight->tally);
        reset();
        const double begin = thread_seconds();
        CML_TRY(cml_engine_run_range(&CML_LEVELED(cml_engine_cpu_, CML_LEVEL), flight->cpu, 0,
                                     flight->photons, &flight->tally, err));
        flight->seconds = thread_seconds() - begin;
        if (flight->seconds >= 0.4) return CML_OK;
    }
}

/* The counting of a bench: `reset` is called before a flight, `report` after it. */
struct bench_count {
    const char *name, *head; /* name of the program, and head of the table */
    void (*reset)(void);
    void (*report)(const char *path, const struct bench_flight *flight);
};

static inline cml_status bench_measure(const struct bench_count *bench, const char *path,
                                       struct cml_error *err)
{
    struct bench_flight flight;
    CML_TRY(bench_open(path, CML_SURFACE_AUTO, &flight, err));
    CML_TRY(bench_fly(&flight, bench->reset, err));
    bench->report(path, &flight);
    bench_close(&flight);
    return CML_OK;
}

/* The main function of a bench: prints a line of the table for every scene in its arguments. Returns the
 * exit code. */
static inline int bench_scenes(const struct bench_count *bench, int argc, char **argv)
{
    struct cml_error err;
    printf("%s\n", bench->head);
    for (int i = 1; i < argc; i++) {
        if (bench_measure(bench, argv[i], &err) == CML_OK) continue;
        fprintf(stderr, "%s: %s\n", bench->name, err.text);
        return 2;
    }
    return 0;
}
