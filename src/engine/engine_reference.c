/* SPDX-License-Identifier: MIT */
#include "engine/engine_reference.h"

/* All kernels that this file includes are compiled in double precision. */
#define CML_DOUBLE
#include "engine/scalar_walk_inl.h"
#include "engine/world.h"

#include <stdlib.h>

/* An engine is its world: it keeps no state between ranges. */
static cml_status reference_open(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                 const struct cml_engine_options *options, void **self, struct cml_error *err)
{
    struct cml_owned_world *world = malloc(sizeof *world);
    *self = NULL;
    if (!world) return cml_fail_memory(err, sizeof *world, "an engine");
    const cml_status status = cml_owned_world_create(scene, surfaces, options, world, err);
    if (status != CML_OK)
        free(world);
    else
        *self = world;
    return status;
}

static cml_status reference_run(void *self, uint64_t first, uint64_t count, struct cml_tally *tally,
                                struct cml_error *err)
{
    (void)err;
    const struct cml_owned_world *world = self;
    run_packets(&world->world, first, count, tally);
    return CML_OK;
}

static cml_status reference_trace(void *self, uint64_t index, cml_trace_function *on_event, void *context,
                                  struct cml_fate_record *record, struct cml_error *err)
{
    const struct cml_owned_world *world = self;
    return trace_packets(&world->world, index, 1, on_event, context, record, err);
}

static cml_status reference_fates(void *self, uint64_t first, uint64_t count, struct cml_fate_record *records,
                                  struct cml_error *err)
{
    const struct cml_owned_world *world = self;
    return trace_packets(&world->world, first, count, NULL, NULL, records, err);
}

static int reference_threads(const void *self)
{
    (void)self;
    return 1;
}

static void reference_close(void *self)
{
    if (!self) return;
    cml_owned_world_free(self);
    free(self);
}

const struct cml_engine cml_engine_reference = {
    .name = "reference",
    .description = "double precision, one packet at a time, one thread: the oracle",
    .open = reference_open,
    .run = reference_run,
    .trace = reference_trace,
    .fates = reference_fates,
    .threads = reference_threads,
    .close = reference_close,
};
