/* The OpenCL engine: the walk of kernels/walk.h on one or several devices, which share each range of photons.
 *
 *      host:    give photons --> start --> finish --> start --> finish ...  --> collect cells into the tally
 *                                  |         ^          |         ^
 *      device:                     +-- steps-+          +-- steps-+      packets stay on the device
 *
 * The host gives a device photon indices, calls the kernel again and again until it has flown them all, and
 * adds its cells to the tally. A call flies a bounded number of steps, and packets stay on the device from
 * one call to the next.
 * SPDX-License-Identifier: MIT */
#include "engine/scalar_walk_inl.h"
#include "engine/world.h"

#include "engine/opencl/engine_opencl.h"
#include "base/clock.h"
#include "engine/opencl/opencl_parts.h"

#include <stdlib.h>
#include <string.h>

struct opencl_engine {
    struct cml_owned_world owned; /* the world of which the devices have copies */
    int count;
    struct cml_opencl_flight *flights; /* [count] */
    /* Packets that a device is given at a time; 0: by the number that is left. */
    uint64_t chunk;
    uint64_t *cells;        /* scratch: the cells of one device */
    struct cml_tally tally; /* the tally of a call of run; zero between calls */
};

/* Frees the engine; also one that was opened only in part. */
static void opencl_close(void *self)
{
    struct opencl_engine *engine = self;
    if (!engine) return;
    for (int i = 0; i < engine->count; i++) cml_opencl_flight_close(&engine->flights[i]);
    cml_owned_world_free(&engine->owned);
    free(engine->flights);
    free(engine->cells);
    cml_tally_free(&engine->tally);
    free(engine);
}

/* Refuses meshes. Devices have no mesh query: meshes are searched on the host, in double precision and with
 * exact predicates. */
static cml_status refuse_meshes(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                struct cml_error *err)
{
    for (int b = 0; b < surfaces->count; b++)
        if (surfaces->item[b].kind == CML_SURFACE_MESH)
            return cml_fail(
                err, CML_E_INPUT,
                "%s: boundary %d is a mesh (expected planes and heightfields; the opencl engine flies no "
                "meshes)",
                scene->file, b);
    for (int k = 0; k < scene->num_bodies; k++)
        if (scene->bodies[k].form == CML_BODY_MESH)
            return cml_fail(
                err, CML_E_INPUT,
                "%s:%d: body %d is a mesh (expected spheres and cylinders; the opencl engine flies "
                "no meshes)",
                scene->file, scene->bodies[k].line, k + 1);
    return CML_OK;
}

/* Refuses faces and ports, which devices do not know, and scenes with results that devices do not score:
 * time, directions, detectors, fluence, saved packets, maps, volumes and facets (kernels/device_deposits.h).
 */
static cml_status refuse_maps(const struct cml_scene *scene, struct cml_error *err)
{
    static const char no_maps[] = "records no maps, volumes or facets";
    const struct {
        bool there;
        int line;
        const char *name, *why;
    } lines[] = {{scene->num_contacts > 0, scene->num_contacts > 0 ? scene->contacts->line : 0,
                  "face or port", "knows none: boundary 0 has a face"},
                 {scene->time.gates > 0, scene->time.line, "time", "keeps no time"},
                 {scene->directions.nt > 0, scene->directions.line, "directions", "scores none"},
                 {scene->num_detectors > 0, scene->num_detectors > 0 ? scene->detectors[0].line : 0,
                  "detector", "has none"},
                 {scene->fluence.line > 0, scene->fluence.line, "fluence", "scores none"},
                 {scene->saved.limit > 0, scene->saved.line, "photons", "saves none"},
                 {scene->map.nx > 0, scene->map.line, "map", no_maps},
                 {scene->facets, scene->line, "facets", no_maps}};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++)
        if (lines[i].there)
            return cml_fail(err, CML_E_INPUT,
                            "%s:%d: a %s line and --engine opencl, which %s (expected --engine cpu)",
                            scene->file, lines[i].line, lines[i].name, lines[i].why);
    return CML_OK;
}

/* Returns the parts of a scene that every device gets. If only_planes is true, the device's compiler leaves
 * out all that curved boundaries need, and packets have more registers. */
static struct cml_opencl_scene scene_of(const struct opencl_engine *engine,
                                        const struct cml_surface_set *surfaces,
                                        const struct cml_engine_options *options,
                                        const struct cml_tally_grid *grid)
{
    struct cml_tally_grid one_group = *grid; /* a piece belongs to one batch, so one group is enough */
    one_group.cell_errors = false;
    struct cml_opencl_scene scene = {
        .world = &engine->owned,
        .only_planes = true,
        .cells = cml_tally_cells(&one_group),
        .build_options = options->build_options,
        .on_note = options->on_note,
        .group = options->group,
        .loose_division = options->loose_division,
    };
    for (int b = 0; b < surfaces->count; b++)
        if (surfaces->item[b].kind != CML_SURFACE_PLANE) scene.only_planes = false;
    if (surfaces->bodies.count > 0) scene.only_planes = false;
    for (int b = 0; b < surfaces->count + surfaces->bodies.count; b++)
        if (engine->owned.surfaces[b].rough.kind) scene.rough = true;
    return scene;
}

/* Opens all devices at once, so that a device that refuses is found before any packet flies. */
static cml_status open_flights(const struct cml_opencl_device *devices, int count,
                               const struct cml_opencl_scene *scene, struct opencl_engine *engine,
                               struct cml_error *err)
{
    engine->flights = calloc((size_t)count, sizeof *engine->flights);
    if (!engine->flights) return cml_fail_memory(err, count * (double)sizeof *engine->flights, "devices");
    for (; engine->count < count; engine->count++)
        CML_TRY(cml_opencl_flight_open(&devices[engine->count], scene, &engine->flights[engine->count], err));
    engine->cells = calloc(engine->flights[0].num_cells, sizeof *engine->cells);
    if (!engine->cells) return cml_fail_memory(err, (double)engine->flights[0].num_cells * 8, "tallies");
    return CML_OK;
}

/* Opens the chosen OpenCL devices for a scene. Refuses meshes, maps and --aim first, which devices do not
 * support. */
static cml_status open_engine(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                              const struct cml_engine_options *options, struct opencl_engine *engine,
                              struct cml_error *err)
{
    const struct cml_tally_grid grid = cml_engine_grid(scene, surfaces, options);
    CML_FREED struct cml_opencl_device *devices = NULL;
    int count = 0;
    CML_TRY(refuse_meshes(scene, surfaces, err));
    CML_TRY(refuse_maps(scene, err));
    if (options->tail || options->windows)
        return cml_fail(err, CML_E_INPUT,
                        "--aim and --engine opencl, which scores no expected values and splits no packets "
                        "(expected --engine cpu)");
    CML_TRY(cml_opencl_select(options->device, options->local_rank, &devices, &count, err));
    CML_TRY(cml_owned_world_create(scene, surfaces, options, &engine->owned, err));
    CML_TRY(cml_tally_create(&grid, &engine->tally, err));
    const struct cml_opencl_scene job = scene_of(engine, surfaces, options, &grid);
    return open_flights(devices, count, &job, engine, err);
}

/* Opens an engine. options->chunk: packets that a device is given at a time, for tests; it never changes a
 * result. */
static cml_status opencl_open(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                              const struct cml_engine_options *options, void **self, struct cml_error *err)
{
    struct opencl_engine *engine = calloc(1, sizeof *engine);
    *self = NULL;
    if (!engine) return cml_fail_memory(err, sizeof *engine, "an engine");
    engine->chunk = options->chunk;
    const cml_status status = open_engine(scene, surfaces, options, engine, err);
    if (status != CML_OK)
        opencl_close(engine);
    else
        *self = engine;
    return status;
}

/* The photons of a piece that no device has been given yet. */
struct pool {
    uint64_t first, count;
};

/* Gives a device photons of the pool. A single device takes all. Several devices take half of their fair
 * share each time, so that fast ones come back sooner and all end together; but never fewer than fill the
 * device once. */
static void give(const struct opencl_engine *engine, struct cml_opencl_flight *flight, struct pool *pool)
{
    const uint64_t share = engine->count > 1 ? pool->count / (2 * (uint64_t)engine->count) : pool->count;
    const uint64_t least = flight->most_items;
    uint64_t part = engine->chunk ? engine->chunk : (share > least ? share : least);
    if (part > pool->count) part = pool->count;
    cml_opencl_flight_give(flight, pool->first, CML_NUM_BATCHES, part);
    pool->first += CML_NUM_BATCHES * part;
    pool->count -= part;
}

/* Calls the kernel once on every device that has work. All calls are started before any is waited for, so
 * that they run at the same time. *active: number of calls; 0: the pool is empty and no packet is under way.
 * tally: gets the indices of lost packets; NULL: not wanted. */
static cml_status call_all(struct opencl_engine *engine, struct pool *pool, int *active,
                           struct cml_tally *tally, struct cml_error *err)
{
    bool started[64] = {false};
    *active = 0;
    for (int i = 0; i < engine->count; i++) {
        struct cml_opencl_flight *flight = &engine->flights[i];
        if (pool->count > 0 && cml_opencl_flight_dry(flight)) give(engine, flight, pool);
        if (cml_opencl_flight_done(flight)) continue;
        CML_TRY(cml_opencl_flight_start(flight, err));
        started[i] = true;
        ++*active;
    }
    for (int i = 0; i < engine->count; i++) {
        struct cml_opencl_flight *flight = &engine->flights[i];
        if (!started[i]) continue;
        CML_TRY(cml_opencl_flight_finish(flight, err));
        for (cml_u32 k = 0; tally && k < flight->counters.num_lost && k < CML_LOST_KEPT; k++)
            cml_lost_list_add(&tally->lost, flight->counters.lost[k]);
    }
    return CML_OK;
}

/* Adds A_rz of a device's block to the tally. lanes: packets of a work-item on that device. */
static void add_absorption(const uint64_t *cells, uint32_t lanes, size_t group, struct cml_tally *tally)
{
    uint64_t *const A_rz = tally->A_rz + group * tally->layout.size[CML_ARRAY_A_rz];
    const int rows = tally->grid.nz + 2;
    for (int ir = 0; ir <= tally->grid.nr; ir++) {
        const uint64_t *from =
            cells + (size_t)cml_device_column(ir, tally->grid.nr, (int)lanes) * (size_t)rows;
        uint64_t *to = A_rz + (size_t)ir * (size_t)rows;
        for (int iz = 0; iz < rows; iz++) to[iz] += from[iz];
    }
}

/* Adds a device's block of cells to the tally (layout: kernels/device_layout.h). */
static void add_cells(const uint64_t *cells, uint32_t lanes, int batch, struct cml_tally *tally)
{
    const size_t group = (size_t)(batch % cml_cell_groups(&tally->grid)),
                 exits = tally->layout.size[CML_ARRAY_Rd_ra], others = tally->layout.Rd_ra;
    const uint64_t *const reflected = cells + CML_CELL_LAYER + others, *const transmitted = reflected + exits;
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++) tally->balance[i] += cells[CML_CELL_BALANCE + (cml_u32)i];
    for (int i = 0; i < CML_NUM_COUNTS; i++) tally->count[i] += cells[CML_CELL_COUNT + (cml_u32)i];
    for (size_t i = 0; i < others; i++) tally->A_l[i] += cells[CML_CELL_LAYER + i];
    for (size_t i = 0; i < exits; i++) tally->Rd_ra[group * exits + i] += reflected[i];
    for (size_t i = 0; i < exits; i++) tally->Tt_ra[group * exits + i] += transmitted[i];
    if (tally->grid.absorption) add_absorption(transmitted + exits, lanes, group, tally);
}

/* Limits of a piece after the run is to stop: when both are exceeded, its packets are given up. The calls are
 * those of a busy machine, the seconds those of a fast one. */
#define MOST_LATE_CALLS 6
#define MOST_LATE_SECONDS 0.3

/* Calls the kernel until all packets of the piece have ended, then collects each device's cells. The tally is
 * complete when this returns, so a checkpoint need not know of devices. */
static cml_status fly_piece(struct opencl_engine *engine, const struct cml_work *work,
                            const struct cml_piece *piece, struct cml_error *err)
{
    struct pool pool = {piece->first, piece->count};
    int active = 1, late = 0;
    double since = 0;
    for (int i = 0; i < engine->count; i++)
        CML_TRY(cml_opencl_flight_begin(&engine->flights[i], piece->count, 0, err));
    while (active > 0) {
        CML_TRY(call_all(engine, &pool, &active, &engine->tally, err));
        if (!work->stops || !work->stops(work->context)) continue;
        if (late++ == 0) since = cml_now();
        if (late > MOST_LATE_CALLS && cml_now() - since > MOST_LATE_SECONDS) return cml_engine_given_up(err);
    }
    for (int i = 0; i < engine->count; i++) {
        CML_TRY(cml_opencl_flight_collect(&engine->flights[i], engine->cells, err));
        add_cells(engine->cells, engine->flights[i].lanes, piece->batch, &engine->tally);
    }
    return CML_OK;
}

/* Flies all pieces of the work. The devices share each piece. */
static cml_status opencl_run(void *self, const struct cml_work *work, struct cml_error *err)
{
    struct opencl_engine *engine = self;
    struct cml_piece piece;
    while (work->next(work->context, CML_TALLY_MAX_PHOTONS, 1, &piece)) {
        CML_TRY(fly_piece(engine, work, &piece, err));
        work->end_batch(work->context, piece.batch, &engine->tally);
    }
    work->add(work->context, &engine->tally);
    return CML_OK;
}

/* Converts a device's record into one with shares of a packet and coordinates of the scene. */
static void copy_record(const struct cml_world *world, uint64_t index, const struct cml_device_fate *from,
                        struct cml_fate_record *to)
{
    const struct cml_setup *setup = &world->setup;
    *to = (struct cml_fate_record){
        .fate = from->fate,
        .cause = from->cause,
        .weight = from->w,
        .interactions = from->interactions,
        .boundary_events = from->boundary_events,
        .specular = cml_split_off(world, index) * CML_WEIGHT_UNIT,
        .absorbed = (double)from->absorbed * CML_WEIGHT_UNIT,
        .backing = (double)from->backing * CML_WEIGHT_UNIT,
        .exit = {from->exit_x + setup->x0, from->exit_y + setup->y0},
        .direction = {from->u.x, from->u.y, from->u.z},
    };
}

/* Reads how `count` packets from number `first` ended from the first device, and converts them to records of
 * the host. */
static cml_status read_records(struct opencl_engine *engine, uint64_t first, uint64_t count,
                               struct cml_fate_record *records, struct cml_error *err)
{
    const size_t bytes = count * sizeof(struct cml_device_fate);
    CML_FREED struct cml_device_fate *fates = malloc(bytes);
    if (!fates) return cml_fail_memory(err, (double)bytes, "fates");
    CML_TRY(cml_opencl_flight_read(engine->flights, CML_BUFFER_FATES, fates, bytes, err));
    for (uint64_t i = 0; i < count; i++) copy_record(&engine->owned.world, first + i, &fates[i], &records[i]);
    return CML_OK;
}

/* Flies packets on the first device and records how each ends, for `crosscheck`. Its sums are thrown away. */
static cml_status opencl_fates(void *self, uint64_t first, uint64_t count, struct cml_fate_record *records,
                               struct cml_error *err)
{
    struct opencl_engine *engine = self;
    struct cml_opencl_flight *flight = engine->flights;
    CML_TRY(cml_opencl_flight_begin(flight, count, count, err));
    cml_opencl_flight_give(flight, first, 1, count);
    while (!cml_opencl_flight_done(flight)) {
        CML_TRY(cml_opencl_flight_start(flight, err));
        CML_TRY(cml_opencl_flight_finish(flight, err));
    }
    CML_TRY(cml_opencl_flight_collect(flight, engine->cells, err));
    return read_records(engine, first, count, records, err);
}

/* Returns the name of an event, from the packet before and after it. */
static const char *event_name(const struct cml_packet *before, const struct cml_packet *after)
{
    if (after->interactions > before->interactions) return "interact";
    if (after->boundary_events == before->boundary_events) return "end";
    return after->medium == before->medium ? "reflect" : "transmit";
}

/* Hands an event to the listener, if there is one. before: the packet before the event. */
static void tell(const struct cml_owned_world *owned, const char *what, const struct cml_packet *before,
                 const struct cml_packet *packet, cml_trace_function *on_event, void *context)
{
    struct tracing tracing = {&owned->world, on_event, context, before->rough_draws};
    if (on_event) forward_event(&tracing, what, packet);
}

/* Follows one packet by calls of one step. After each call the packet is read back and compared with its
 * state before. The launch happens on the device within the first step, so the host repeats it for its
 * event. */
static cml_status follow(struct opencl_engine *engine, struct cml_opencl_flight *flight, uint64_t index,
                         cml_trace_function *on_event, void *context, struct cml_error *err)
{
    struct cml_packet before, after;
    cml_launch(&engine->owned.world, index, &before);
    tell(&engine->owned, "launch", &before, &before, on_event, context);
    cml_opencl_flight_give(flight, index, 1, 1);
    do {
        flight->call.steps = 1;
        CML_TRY(cml_opencl_flight_start(flight, err));
        CML_TRY(cml_opencl_flight_finish(flight, err));
        CML_TRY(cml_opencl_flight_read(flight, CML_BUFFER_PACKETS, &after, sizeof after, err));
        const char *what = event_name(&before, &after);
        if (strcmp(what, "end") != 0) tell(&engine->owned, what, &before, &after, on_event, context);
        before = after;
    } while (!cml_opencl_flight_done(flight));
    tell(&engine->owned, "end", &after, &after, on_event, context);
    return CML_OK;
}

/* Traces a packet. Without a listener, the packet is flown like any other that has a record. */
static cml_status opencl_trace(void *self, uint64_t index, cml_trace_function *on_event, void *context,
                               struct cml_fate_record *record, struct cml_error *err)
{
    struct opencl_engine *engine = self;
    struct cml_opencl_flight *flight = engine->flights;
    const cml_u32 steps = flight->call.steps;
    if (!on_event) return opencl_fates(self, index, 1, record, err);
    CML_TRY(cml_opencl_flight_begin(flight, 1, 1, err));
    const cml_status status = follow(engine, flight, index, on_event, context, err);
    flight->call.steps = steps;
    CML_TRY(status);
    CML_TRY(cml_opencl_flight_collect(flight, engine->cells, err));
    return read_records(engine, index, 1, record, err);
}

/* Returns the number of compute units of all devices. */
static int opencl_threads(const void *self)
{
    const struct opencl_engine *engine = self;
    unsigned units = 0;
    for (int i = 0; engine && i < engine->count; i++) units += engine->flights[i].device.info.units;
    return (int)units;
}

/* Returns the memory that the engine takes on the host, in bytes: twice the world, because a device that is
 * the processor keeps its buffers in the same memory. */
static double opencl_bytes(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    return 2 * cml_world_bytes(scene, surfaces);
}

const struct cml_engine cml_engine_opencl = {
    .name = "opencl",
    .open = opencl_open,
    .run = opencl_run,
    .trace = opencl_trace,
    .fates = opencl_fates,
    .threads = opencl_threads,
    .bytes = opencl_bytes,
    .close = opencl_close,
};
