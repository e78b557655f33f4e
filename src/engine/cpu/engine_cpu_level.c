/* The CPU engine for one level of the processor: compiled once for each (CML_LEVEL, see CMakeLists.txt), so
 * that one binary is fast on all machines. Only instructions differ; results are the same to the last bit.
 * Everything hot is in this one translation unit. The headers bundle_*_inl.h are its code, cut into files by
 * subject: a loop over lanes becomes vector instructions only if all that it calls is inlined, and then in
 * those of this level only if it is compiled with this file's options. SPDX-License-Identifier: MIT */
#include "engine/cpu/bundle_walk_inl.h"
#include "engine/scalar_walk_inl.h"
#include "engine/world.h"

#include <omp.h>
#include <stddef.h>
#include <stdlib.h>

struct cpu_engine {
    struct cml_owned_world owned;
    struct cml_lane_medium *media; /* [num_layers + 2] */
    struct cml_tally *tallies;     /* one for each thread but those that score into the caller's; zero */
    int threads, num_tallies;
    int first_apart; /* the first thread that has a tally of its own: 0 where all share a large A_rz, else 1
                      */
    uint64_t chunk;
};

static void cpu_close(void *self)
{
    struct cpu_engine *cpu = self;
    if (!cpu) return;
    for (int i = 0; i < cpu->num_tallies; i++) cml_tally_free(&cpu->tallies[i]);
    free(cpu->tallies);
    free(cpu->media);
    cml_owned_world_free(&cpu->owned);
    free(cpu);
}

/* A tally for each thread, so that no addition needs a lock. Where A_rz is too large for a copy each
 * (cml_grid_of_thread), all threads add to the one of the caller, with atomic additions, and the first thread
 * needs one of its own, too. */
static cml_status create_tallies(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                 const struct cml_engine_options *options, struct cpu_engine *cpu,
                                 struct cml_error *err)
{
    const struct cml_grid full = cml_engine_grid(scene, surfaces, options);
    const struct cml_grid grid = cml_grid_of_thread(&full);
    cpu->first_apart = grid.absorption == full.absorption ? 1 : 0;
    cpu->tallies = calloc((size_t)cpu->threads, sizeof *cpu->tallies);
    if (!cpu->tallies) return cml_fail_memory(err, cpu->threads * cml_tally_bytes(&grid), "tallies");
    for (int thread = cpu->first_apart; thread < cpu->threads; thread++)
        CML_TRY(cml_tally_create(&grid, &cpu->tallies[cpu->num_tallies++], err));
    return CML_OK;
}

/* Media as lanes hold them; the same for all threads. */
static cml_status create_lane_media(struct cpu_engine *cpu, struct cml_error *err)
{
    const int count = cpu->owned.world.setup.num_layers + 2;
    cpu->media = calloc((size_t)count, sizeof *cpu->media);
    if (!cpu->media) return cml_fail_memory(err, count * (double)sizeof *cpu->media, "the media");
    for (int m = 0; m < count; m++) cpu->media[m] = cml_lane_medium_of(&cpu->owned.world, m);
    return CML_OK;
}

static cml_status cpu_open(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                           const struct cml_engine_options *options, void **self, struct cml_error *err)
{
    struct cpu_engine *cpu = calloc(1, sizeof *cpu);
    *self = NULL;
    if (!cpu) return cml_fail_memory(err, sizeof *cpu, "an engine");
    cpu->threads = options->threads > 0 ? options->threads : omp_get_max_threads();
    cpu->chunk = options->chunk > 0 ? options->chunk : 128;
    cml_status status = cml_owned_world_create(scene, surfaces, options, &cpu->owned, err);
    if (status == CML_OK) status = create_lane_media(cpu, err);
    if (status == CML_OK) status = create_tallies(scene, surfaces, options, cpu, err);
    if (status != CML_OK)
        cpu_close(cpu);
    else
        *self = cpu;
    return status;
}

/* Photon indices that no thread has taken yet. */
struct pool {
    uint64_t first, count, chunk, threads;
    uint64_t taken; /* shared by all threads */
};

/* How many photons a thread takes next. Towards the end less and less (guided scheduling), so that all
 * threads end at about the same time. */
static uint64_t choose_chunk(const struct pool *pool)
{
    const uint64_t least = 16;
    uint64_t taken;
    if (pool->threads == 1 || pool->chunk <= least) return pool->chunk;
#pragma omp atomic read
    taken = pool->taken;
    const uint64_t left = taken < pool->count ? pool->count - taken : 0, fair = left / (8 * pool->threads);
    return fair > least ? (fair < pool->chunk ? fair : pool->chunk) : least;
}

/* The next photons of the pool, for struct cml_range_source. Which thread flies which photons does not
 * matter: a photon owns its random numbers, and sums are of integers. */
static int take_chunk(void *context, uint64_t *first, uint64_t *count)
{
    struct pool *pool = context;
    const uint64_t chunk = choose_chunk(pool);
    uint64_t begin;
#pragma omp atomic capture
    {
        begin = pool->taken;
        pool->taken += chunk;
    }
    if (begin >= pool->count) return 0;
    *first = pool->first + begin;
    *count = pool->count - begin < chunk ? pool->count - begin : chunk;
    return 1;
}

/* Adds to the tally what threads have scored in tallies of their own. Each thread adds one part of the cells,
 * of all of those tallies, so no two write the same cell. */
static void gather_part(struct cpu_engine *cpu, struct cml_tally *tally)
{
    const int parts = omp_get_num_threads();
    for (int i = 0; i < parts - cpu->first_apart; i++)
        cml_tally_move(tally, &cpu->tallies[i], omp_get_thread_num(), parts);
}

/* All threads fly photons of the range until there are none, then gather their tallies. */
static cml_status cpu_run(void *self, uint64_t first, uint64_t count, struct cml_tally *tally,
                          struct cml_error *err)
{
    (void)err;
    struct cpu_engine *cpu = self;
    struct pool pool = {
        .first = first, .count = count, .chunk = cpu->chunk, .threads = (uint64_t)cpu->threads};
    const struct cml_range_source source = {take_chunk, &pool};
#pragma omp parallel num_threads(cpu->threads)
    {
        const int apart = omp_get_thread_num() - cpu->first_apart;
        struct cml_tally *mine = apart < 0 ? tally : &cpu->tallies[apart];
        if (apart >= 0) cml_tally_borrow(mine, tally);
        cml_bundle_walk(&cpu->owned.world, cpu->media, &source, mine);
#pragma omp barrier
        gather_part(cpu, tally);
    }
    return CML_OK;
}

static cml_status cpu_trace(void *self, uint64_t index, cml_trace_function *on_event, void *context,
                            struct cml_fate_record *record, struct cml_error *err)
{
    const struct cpu_engine *cpu = self;
    return trace_packets(&cpu->owned.world, index, 1, on_event, context, record, err);
}

/* How packets end, by the scalar walk: bundles keep no record of single packets, and equal that walk bit for
 * bit. */
static cml_status cpu_fates(void *self, uint64_t first, uint64_t count, struct cml_fate_record *records,
                            struct cml_error *err)
{
    const struct cpu_engine *cpu = self;
    const uint64_t parts = (count + cpu->chunk - 1) / cpu->chunk;
    cml_status status = CML_OK;
#pragma omp parallel for num_threads(cpu->threads) schedule(dynamic)
    for (uint64_t part = 0; part < parts; part++) {
        const uint64_t begin = part * cpu->chunk;
        const uint64_t size = count - begin < cpu->chunk ? count - begin : cpu->chunk;
        struct cml_error mine;
        const cml_status failed =
            trace_packets(&cpu->owned.world, first + begin, size, NULL, NULL, records + begin, &mine);
        if (failed != CML_OK) {
#pragma omp critical
            *err = mine, status = failed;
        }
    }
    return status;
}

/* Without an engine: as many as one would take. */
static int cpu_threads(const void *self)
{
    return self ? ((const struct cpu_engine *)self)->threads : omp_get_max_threads();
}

#define CML_PASTE(a, b) a##b
#define CML_LEVELED(name, level) CML_PASTE(name, level)

/* declared in engine_cpu.c only, which picks one */
extern const struct cml_engine CML_LEVELED(cml_engine_cpu_, CML_LEVEL);
const struct cml_engine CML_LEVELED(cml_engine_cpu_, CML_LEVEL) = {
    .name = "cpu",
    .description = "single precision, bundles of packets in vector loops, OpenMP threads",
    .open = cpu_open,
    .run = cpu_run,
    .trace = cpu_trace,
    .fates = cpu_fates,
    .threads = cpu_threads,
    .close = cpu_close,
};
