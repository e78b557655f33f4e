/* The CPU engine for one level of the processor. This file is compiled once for each level (CML_LEVEL, see
 * CMakeLists.txt), so that one binary is fast on all machines. The levels differ only in instructions;
 * results are the same to the last bit.
 *
 *      engine_cpu.c  chooses -->  engine_cpu_level.c, level v4    with   bundle_*_inl.h
 *                                 engine_cpu_level.c, level v3    with   bundle_*_inl.h
 *                                 engine_cpu_level.c, baseline    with   bundle_*_inl.h
 *
 * All hot code is in this one translation unit. The headers bundle_*_inl.h are its code, cut into files by
 * subject. A loop over lanes becomes vector instructions only if all that it calls is inlined, and
 * instructions of this level only if it is compiled with this file's options.
 * SPDX-License-Identifier: MIT */
#include "engine/cpu/bundle_walk_inl.h"
#include "engine/threads.h"
#include "engine/scalar_walk_inl.h"
#include "engine/world.h"
#include "vector/processor.h"

#include <omp.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>

struct cpu_engine {
    struct cml_owned_world owned;
    struct cml_lane_medium *media; /* [num_layers + 2 + num_bodies] */
    /* [num_tallies], zero between calls of run. The first has the arrays that all threads share. */
    struct cml_tally *tallies;
    /* [threads][CML_LANES][cml_row_factors] of packets under way (P16); NULL without rows. */
    real *factors;
    struct cml_branches *branches; /* [threads] */
    int threads, num_tallies;
    uint64_t chunk;
};

/* Frees an engine of the processor; NULL is allowed, and so is an engine that was not opened completely. */
static void cpu_close(void *self)
{
    struct cpu_engine *cpu = self;
    if (!cpu) return;
    for (int i = 0; i < cpu->num_tallies; i++) cml_tally_free(&cpu->tallies[i]);
    free(cpu->tallies);
    free(cpu->media);
    free(cpu->factors);
    for (int i = 0; cpu->branches && i < cpu->threads; i++) cml_branches_free(&cpu->branches[i]);
    free(cpu->branches);
    cml_owned_world_free(&cpu->owned);
    free(cpu);
}

/* Makes a tally for each thread, so that additions need no lock. Large arrays belong to the first tally, and
 * all threads add to them by atomic additions. If even A_rz or the fluence is too large for a copy each, the
 * first tally belongs to no thread, and there is one more. */
static cml_status create_tallies(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                 const struct cml_engine_options *options, struct cpu_engine *cpu,
                                 struct cml_error *err)
{
    const struct cml_tally_grid full = cml_engine_grid(scene, surfaces, options);
    const struct cml_tally_grid grid = cml_tally_grid_of_thread(&full);
    const int count = cpu->threads + (cpu->threads > 1 && cml_tally_grid_is_shared(&full) ? 1 : 0);
    cpu->tallies = calloc((size_t)count, sizeof *cpu->tallies);
    if (!cpu->tallies) return cml_fail_memory(err, count * cml_tally_bytes(&grid), "tallies");
    CML_TRY(cml_tally_create(&full, &cpu->tallies[cpu->num_tallies++], err));
    while (cpu->num_tallies < count) {
        struct cml_tally *tally = &cpu->tallies[cpu->num_tallies++];
        CML_TRY(cml_tally_create(&grid, tally, err));
        cml_tally_borrow(tally, &cpu->tallies[0]);
    }
    for (int i = 0; full.saved.limit && i < count; i++) cpu->tallies[i].saved->to = options->saved;
    return CML_OK;
}

/* Makes the properties of all media in the form that lanes load; they are the same for all threads. */
static cml_status create_lane_media(struct cpu_engine *cpu, struct cml_error *err)
{
    const int count = cpu->owned.world.setup.num_layers + 2 + cpu->owned.world.setup.num_bodies;
    cpu->media = calloc((size_t)count, sizeof *cpu->media);
    if (!cpu->media) return cml_fail_memory(err, count * (double)sizeof *cpu->media, "the media");
    for (int m = 0; m < count; m++) cpu->media[m] = cml_lane_medium_of(&cpu->owned.world, m);
    return CML_OK;
}

/* Returns the number of factors for the rows of one thread. */
static size_t num_factors(const struct cpu_engine *cpu)
{
    const size_t rows = (size_t)cpu->owned.world.rows.count;
    return rows ? (size_t)CML_LANES * cml_row_factors(rows) : 0;
}

/* Allocates for each thread the factors by which rows of a sweep multiply packets' weights. */
static cml_status create_factors(struct cpu_engine *cpu, struct cml_error *err)
{
    const size_t count = (size_t)cpu->threads * num_factors(cpu);
    if (count == 0) return CML_OK;
    cpu->factors = calloc(count, sizeof *cpu->factors);
    return cpu->factors ? CML_OK : cml_fail_memory(err, (double)(count * sizeof(real)), "the rows");
}

/* Makes for each thread a stack of branches, which are parts of split packets that wait for their flight. */
static cml_status create_branches(struct cpu_engine *cpu, struct cml_error *err)
{
    cpu->branches = calloc((size_t)cpu->threads, sizeof *cpu->branches);
    if (!cpu->branches)
        return cml_fail_memory(err, cpu->threads * (double)sizeof *cpu->branches, "packets that wait");
    for (int i = 0; i < cpu->threads; i++)
        CML_TRY(cml_branches_create(&cpu->owned.world, &cpu->branches[i], err));
    return CML_OK;
}

/* Returns the number of threads: `asked`, or, if that is 0, as many as OpenMP would use; at most
 * OMP_THREAD_LIMIT. */
static int choose_threads(int asked)
{
    const int wanted = asked > 0 ? asked : omp_get_max_threads(), most = omp_get_thread_limit();
    return wanted < most ? wanted : most;
}

/* Opens the engine of the processor for a scene: the scene as kernels read it, and per thread a tally and
 * scratch memory. Without --chunk, 1024 packets are flown at a time. */
static cml_status cpu_open(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                           const struct cml_engine_options *options, void **self, struct cml_error *err)
{
    struct cpu_engine *cpu = calloc(1, sizeof *cpu);
    *self = NULL;
    if (!cpu) return cml_fail_memory(err, sizeof *cpu, "an engine");
    cpu->threads = choose_threads(options->threads);
    cpu->chunk = options->chunk > 0 ? options->chunk : 1024;
    cml_status status = cml_owned_world_create(scene, surfaces, options, &cpu->owned, err);
    if (status == CML_OK) status = create_lane_media(cpu, err);
    if (status == CML_OK) status = create_factors(cpu, err);
    if (status == CML_OK) status = create_branches(cpu, err);
    if (status == CML_OK) status = create_tallies(scene, surfaces, options, cpu, err);
    if (status != CML_OK)
        cpu_close(cpu);
    else
        *self = cpu;
    return status;
}

/* The supply of photons of one thread. */
struct supply {
    const struct cml_work *work;
    uint64_t chunk;
    int threads;
    bool ended, given_up;
    struct cml_patience patience;
};

/* Finds the next photons, for struct cml_range_source. Any thread may fly any photons, because a photon owns
 * its random numbers, and sums are of integers. Once there are no more, the work is not asked again. */
static int next_photons(void *context, uint64_t *first, uint64_t *count)
{
    struct supply *supply = context;
    const struct cml_work *work = supply->work;
    struct cml_piece piece;
    if (supply->ended) return 0;
    supply->ended = !work->next(work->context, supply->chunk, supply->threads, &piece);
    if (supply->ended) return 0;
    *first = piece.first;
    *count = piece.count;
    return 1;
}

/* Tells the caller of the engine that a batch is complete. */
static void end_batch(void *context, int batch, struct cml_tally *tally)
{
    const struct cml_work *work = ((const struct supply *)context)->work;
    work->end_batch(work->context, batch, tally);
}

/* True if the run was to stop a while ago and this thread still flies. The supply then remembers that the
 * thread's packets were given up. */
static int gives_up(void *context)
{
    struct supply *supply = context;
    supply->given_up = cml_engine_gives_up(supply->work, &supply->patience);
    return supply->given_up;
}

/* Flies batch after batch into the thread's tally. Returns false if packets were given up. */
static bool fly_thread(const struct cpu_engine *cpu, const struct cml_work *work, int number,
                       struct cml_tally *tally)
{
    real *const factors = cpu->factors ? cpu->factors + (size_t)number * num_factors(cpu) : NULL;
    struct supply supply = {.work = work, .chunk = cpu->chunk, .threads = cpu->threads};
    const struct cml_range_source source = {next_photons, end_batch, gives_up, &supply};
    cml_bundle_walk(&cpu->owned.world, cpu->media, &source, factors, &cpu->branches[number], tally);
    return !supply.given_up;
}

/* The task of the threads of one call of cpu_run. */
struct cpu_flight {
    struct cpu_engine *cpu;
    const struct cml_work *work;
    atomic_bool given_up;
};

/* Flies the packets of one thread, and adds its tally to the result unless all threads share it. */
static void fly_and_add(void *context, int number)
{
    struct cpu_flight *flight = context;
    struct cpu_engine *cpu = flight->cpu;
    struct cml_tally *mine = &cpu->tallies[number + cpu->num_tallies - cpu->threads];
    if (!fly_thread(cpu, flight->work, number, mine)) atomic_store(&flight->given_up, true);
    cml_saved_hand_in(mine->saved);
    if (mine != cpu->tallies) flight->work->add(flight->work->context, mine);
}

/* Tells the run that the system started fewer threads than asked for. */
static void tell_fewer(void *context, int count)
{
    const struct cml_work *work = ((const struct cpu_flight *)context)->work;
    if (work->fewer) work->fewer(work->context, count);
}

/* Flies with all threads until there is nothing left to take. Only then do they wait for each other, and the
 * arrays that they share are handed in. */
static cml_status cpu_run(void *self, const struct cml_work *work, struct cml_error *err)
{
    struct cpu_engine *cpu = self;
    struct cpu_flight flight = {cpu, work, false};
    cml_run_threads(cpu->threads, &(struct cml_thread_task){&flight, fly_and_add, tell_fewer});
    if (atomic_load(&flight.given_up)) return cml_engine_given_up(err);
    work->add(work->context, cpu->tallies);
    return CML_OK;
}

/* Flies one packet by the scalar walk, and reports its events to `on_event`, for the command `trace`. */
static cml_status cpu_trace(void *self, uint64_t index, cml_trace_function *on_event, void *context,
                            struct cml_fate_record *record, struct cml_error *err)
{
    const struct cpu_engine *cpu = self;
    return trace_packets(&cpu->owned.world, index, 1, on_event, context, record, err);
}

/* The task of the threads of one call of cpu_fates. */
struct cpu_fates {
    const struct cpu_engine *cpu;
    uint64_t first, count;
    struct cml_fate_record *records; /* [count] */
    _Atomic uint64_t taken;          /* number of parts, of `chunk` packets each, that have been taken */
    atomic_flag failed;              /* set by the first thread that fails, to which the error belongs */
    cml_status status;
    struct cml_error *error;
};

/* Takes the next packets for a thread. Returns false if there are no more. */
static bool take_part(struct cpu_fates *fates, uint64_t *begin, uint64_t *size)
{
    const uint64_t chunk = fates->cpu->chunk, parts = (fates->count + chunk - 1) / chunk;
    const uint64_t part = atomic_fetch_add(&fates->taken, 1);
    if (part >= parts) return false;
    *begin = part * chunk;
    *size = fates->count - *begin < chunk ? fates->count - *begin : chunk;
    return true;
}

/* Finds the ends of packets on one thread, part after part, until all parts are taken. Only the first thread
 * that fails reports its error. */
static void trace_parts(void *context, int number)
{
    (void)number;
    struct cpu_fates *fates = context;
    uint64_t begin, size;
    while (take_part(fates, &begin, &size)) {
        struct cml_error mine;
        const cml_status status = trace_packets(&fates->cpu->owned.world, fates->first + begin, size, NULL,
                                                NULL, fates->records + begin, &mine);
        if (status == CML_OK || atomic_flag_test_and_set(&fates->failed)) continue;
        fates->status = status;
        *fates->error = mine;
    }
}

/* Finds the ends of packets by the scalar walk: bundles keep no record of single packets, and equal that walk
 * bit for bit. */
static cml_status cpu_fates(void *self, uint64_t first, uint64_t count, struct cml_fate_record *records,
                            struct cml_error *err)
{
    const struct cpu_engine *cpu = self;
    struct cpu_fates fates = {cpu, first, count, records, 0, ATOMIC_FLAG_INIT, CML_OK, err};
    cml_run_threads(cpu->threads, &(struct cml_thread_task){&fates, trace_parts, NULL});
    return fates.status;
}

/* Returns the threads of an engine; without an engine, as many as it would take. */
static int cpu_threads(const void *self)
{
    return self ? ((const struct cpu_engine *)self)->threads : choose_threads(0);
}

/* Returns the bytes that the engine takes without tallies. */
static double cpu_bytes(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    const double media = (double)surfaces->count + 1 + surfaces->bodies.count;
    return cml_world_bytes(scene, surfaces) + media * sizeof(struct cml_lane_medium);
}

/* The engine of this level. It is declared only in engine_cpu.c, which picks one. */
extern const struct cml_engine CML_LEVELED(cml_engine_cpu_, CML_LEVEL);
const struct cml_engine CML_LEVELED(cml_engine_cpu_, CML_LEVEL) = {
    .name = "cpu",
    .reweights = true,
    .open = cpu_open,
    .run = cpu_run,
    .trace = cpu_trace,
    .fates = cpu_fates,
    .threads = cpu_threads,
    .bytes = cpu_bytes,
    .close = cpu_close,
};
