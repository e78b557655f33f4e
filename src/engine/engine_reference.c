/* SPDX-License-Identifier: MIT */
#include "engine/engine_reference.h"

/* CML_DOUBLE: all kernels that this file includes are compiled in double precision. */
#define CML_DOUBLE
#include "engine/scalar_walk_inl.h"
#include "engine/world.h"

#include <stdlib.h>

struct reference_engine {
    struct cml_owned_world owned;
    real *factor; /* [cml_row_factors] of the packet under way (P16) */
    struct cml_branches branches;
    struct cml_tally tally; /* the tally of a call of run; zero between calls */
};

/* Frees a reference engine; NULL is allowed. */
static void reference_close(void *self)
{
    struct reference_engine *engine = self;
    if (!engine) return;
    cml_owned_world_free(&engine->owned);
    cml_tally_free(&engine->tally);
    free(engine->factor);
    cml_branches_free(&engine->branches);
    free(engine);
}

/* Opens the engine: makes its world, its tally, its stack of branches and its rows. On failure it frees what
 * was made, and *self is NULL. */
static cml_status reference_open(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                 const struct cml_engine_options *options, void **self, struct cml_error *err)
{
    const struct cml_tally_grid grid = cml_engine_grid(scene, surfaces, options);
    struct reference_engine *engine = calloc(1, sizeof *engine);
    *self = NULL;
    if (!engine) return cml_fail_memory(err, sizeof *engine, "an engine");
    cml_status status = cml_owned_world_create(scene, surfaces, options, &engine->owned, err);
    if (status == CML_OK) status = cml_tally_create(&grid, &engine->tally, err);
    if (engine->tally.saved) engine->tally.saved->to = options->saved;
    if (status == CML_OK) status = cml_branches_create(&engine->owned.world, &engine->branches, err);
    const size_t rows = cml_row_stride(&grid);
    engine->factor = calloc(cml_row_factors(rows), sizeof *engine->factor);
    if (status == CML_OK && !engine->factor)
        status = cml_fail_memory(err, (double)(rows * sizeof *engine->factor), "the rows");
    if (status != CML_OK)
        reference_close(engine);
    else
        *self = engine;
    return status;
}

/* Flies little at a time, so that a run that is to stop has little to end, and reports the end of each
 * batch. */
static cml_status reference_run(void *self, const struct cml_work *work, struct cml_error *err)
{
    struct reference_engine *engine = self;
    struct cml_patience patience = {0};
    struct cml_piece piece;
    int batch = -1;
    while (work->next(work->context, 64, 1, &piece)) {
        if (batch >= 0 && piece.batch != batch) work->end_batch(work->context, batch, &engine->tally);
        batch = piece.batch;
        if (!run_piece(&engine->owned.world, work, &piece, &patience, engine->factor, &engine->branches,
                       &engine->tally))
            return cml_engine_given_up(err);
    }
    if (batch >= 0) work->end_batch(work->context, batch, &engine->tally);
    cml_saved_hand_in(engine->tally.saved);
    work->add(work->context, &engine->tally);
    return CML_OK;
}

/* Flies one packet and reports its events to `on_event`, for the command `trace`. */
static cml_status reference_trace(void *self, uint64_t index, cml_trace_function *on_event, void *context,
                                  struct cml_fate_record *record, struct cml_error *err)
{
    const struct reference_engine *engine = self;
    return trace_packets(&engine->owned.world, index, 1, on_event, context, record, err);
}

/* Flies `count` packets from number `first` and records how each one ends, for `crosscheck`. */
static cml_status reference_fates(void *self, uint64_t first, uint64_t count, struct cml_fate_record *records,
                                  struct cml_error *err)
{
    const struct reference_engine *engine = self;
    return trace_packets(&engine->owned.world, first, count, NULL, NULL, records, err);
}

/* Returns the number of threads: the reference engine always uses one. */
static int reference_threads(const void *self)
{
    (void)self;
    return 1;
}

const struct cml_engine cml_engine_reference = {
    .name = "reference",
    .reweights = true,
    .open = reference_open,
    .run = reference_run,
    .trace = reference_trace,
    .fates = reference_fates,
    .threads = reference_threads,
    .bytes = cml_world_bytes,
    .close = reference_close,
};
