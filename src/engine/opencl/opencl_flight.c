/* One device with all that it holds for a scene: buffers, arguments, calls of the kernel, results.
 * SPDX-License-Identifier: MIT */
#include "engine/opencl/opencl_parts.h"

#include "base/clock.h"
#include "base/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CALL_SECONDS 0.05        /* watchdogs of displays wait seconds; the host looks in between */
#define GPU_GROUP 128            /* work-items of a group on a GPU */
#define GPU_ITEMS_PER_UNIT 2048  /* most work-items that a compute unit can keep in flight */
#define CPU_ITEMS_PER_UNIT 32    /* PoCL hands groups to its threads by 32 */
#define LANES_ALONE 16           /* packets of a single work-item: as many as a vector has floats */
#define LOCAL_BYTES_SHARED 16384 /* bytes of a group's local memory: several groups share that of a unit */
#define LOCAL_BYTES_ALONE 98304  /* bytes for a single work-item: they stay in a core's cache */
#define MOST_STEPS (1u << 20)

/* Returns the smaller number; the caller knows that it has at most 32 bits. */
static uint32_t smaller(uint64_t a, uint64_t b)
{
    return (uint32_t)(a < b ? a : b);
}

/* Chooses the numbers of work-items, groups and lanes. On a GPU a work-item flies one packet, and many more
 * items than processors hide the latency of memory. On a CPU a group of one item has its local memory to
 * itself and adds without atomics. It flies several packets as lanes, which the compiler can draw and scatter
 * in vectors (kernels/device_lanes.h). */
static void choose_sizes(const struct cml_opencl_scene *scene, struct cml_opencl_flight *flight)
{
    const struct cml_opencl_info *info = &flight->device.info;
    const bool gpu = strcmp(info->type, "GPU") == 0;
    flight->group = scene->group > 0 ? (uint32_t)scene->group : (gpu ? GPU_GROUP : 1);
    if (info->largest_group && flight->group > info->largest_group) flight->group = info->largest_group;
    const uint32_t items = info->units * (gpu ? GPU_ITEMS_PER_UNIT : CPU_ITEMS_PER_UNIT);
    const uint32_t groups = items / flight->group;
    flight->lanes = flight->group == 1 ? LANES_ALONE : 1;
    flight->most_items = flight->group * (groups > info->units ? groups : info->units);
    flight->call.steps = 256;
}

/* Lays an array behind those before it in the block of cells, and at most `room` of its first cells into
 * local memory. first, local_used: the next free cell in both memories; they are moved on. */
static struct cml_local_part lay_out(uint64_t *first, uint64_t cells, uint64_t room, uint32_t *local_used)
{
    const struct cml_local_part part = {*first, *local_used, smaller(cells, room)};
    *first += cells;
    *local_used += part.count;
    return part;
}

/* Lays out the block of cells, and chooses the cells that a group keeps in local memory (privatised tallies):
 * sums, to which every packet adds, then exits near the axis, then the overflow bin of A_rz, and from the
 * axis outwards as much of A_rz as there is room for. At most half of the local memory is used, so that two
 * groups fit. */
static struct cml_local_parts lay_out_parts(const struct cml_opencl_scene *scene,
                                            struct cml_opencl_flight *flight)
{
    const struct cml_setup *setup = &scene->world->world.setup;
    const uint64_t most = (flight->group == 1 ? LOCAL_BYTES_ALONE : LOCAL_BYTES_SHARED);
    const uint64_t local = flight->device.info.local_memory / 2;
    /* Any device has room for at least 2048 cells. */
    const uint64_t room = (most < local ? most : local) / sizeof(uint64_t);
    const uint64_t exits = ((uint64_t)setup->nr + 1) * (uint64_t)setup->na;
    const uint64_t layers = (uint64_t)setup->num_layers + 2 + (uint64_t)setup->num_bodies;
    uint64_t first = 0;
    uint32_t used = 0;
    struct cml_local_parts parts;
    parts.sums = lay_out(&first, CML_CELL_LAYER + layers, CML_CELL_LAYER + room / 2, &used);
    parts.reflected = lay_out(&first, exits, (room - used) / 8, &used);
    parts.transmitted = lay_out(&first, exits, (room - used) / 8, &used);
    parts.absorbed = lay_out(&first, scene->cells - layers - 2 * exits, room - used, &used);
    flight->num_cells = first;
    flight->call.num_local = used;
    return parts;
}

/* Fails with a message of its own if the device cannot hold tallies and packets, because drivers may notice
 * only when the kernel runs. */
static cml_status check_memory(const struct cml_opencl_flight *flight, struct cml_error *err)
{
    const struct cml_opencl_info *info = &flight->device.info;
    const double mib = 1048576, block = (double)flight->num_cells * sizeof(uint64_t);
    const double all = block + (double)flight->most_items * flight->lanes * CML_DEVICE_PACKET;
    if (block <= (double)info->largest && all <= (double)info->memory) return CML_OK;
    return cml_fail(
        err, CML_E_DEVICE,
        "opencl device %d (%s): tallies and packets take %.4g MiB (expected at most %.4g MiB, %.4g MiB "
        "in one piece)",
        flight->device.number, info->name, all / mib, (double)info->memory / mib,
        (double)info->largest / mib);
}

/* Compiles the kernels for this device and scene. Constants of a whole run are defined for the compiler.
 * Without 64-bit atomics, sums are made of two words. Division and root are rounded correctly if the device
 * can, so that packets take the same way as on the CPU. */
static cml_status build(const struct cml_opencl_scene *scene, struct cml_opencl_flight *flight,
                        struct cml_error *err)
{
    const struct cml_opencl_info *info = &flight->device.info;
    const char *extra = scene->build_options ? scene->build_options : "";
    const bool exact = info->exact_division && !scene->loose_division;
    CML_FREED char *options = NULL;
    CML_TRY(cml_text_format(
        &options, "the compiler's options", err,
        "-cl-single-precision-constant -D CML_GROUP_SIZE=%u -D CML_DEVICE_LANES=%u%s%s%s%s%s%s %s",
        flight->group, flight->lanes, exact ? " -cl-fp32-correctly-rounded-divide-sqrt" : "",
        info->atomics64 ? "" : " -D CML_TWO_WORDS", scene->only_planes ? " -D CML_ONLY_PLANES" : "",
        scene->world->world.setup.num_bodies ? "" : " -D CML_WITHOUT_BODIES",
        scene->world->num_phase_cells ? "" : " -D CML_WITHOUT_PHASES",
        scene->rough ? "" : " -D CML_WITHOUT_ROUGHNESS", extra));
    return cml_opencl_program(&flight->device, flight->context, options, scene->on_note, &flight->program,
                              err);
}

/* Makes a buffer, in place of one that exists, and fills it with `content` if that is not NULL. OpenCL allows
 * no empty buffer, so one without bytes gets eight. */
static cml_status create_buffer(struct cml_opencl_flight *flight, int which, size_t bytes,
                                const void *content, struct cml_error *err)
{
    static const char *const names[CML_NUM_BUFFERS] = {
        "memory for media",  "memory for surfaces", "memory for rings",    "memory for rings",
        "memory for rings",  "memory for rings",    "memory for rings",    "memory for rings",
        "memory for bounds", "memory for bounds",   "memory for bodies",   "memory for bodies",
        "memory for bodies", "memory for bodies",   "memory for phases",   "memory for beams",
        "memory for beams",  "memory for beams",    "memory for counters", "memory for packets",
        "memory for fates",  "memory for tallies"};
    cl_int code = CL_SUCCESS;
    if (flight->buffer[which]) clReleaseMemObject(flight->buffer[which]);
    flight->buffer[which] =
        clCreateBuffer(flight->context, CL_MEM_READ_WRITE, bytes ? bytes : 8, NULL, &code);
    CML_CL(&flight->device, names[which], code, err);
    if (content && bytes)
        CML_CL(&flight->device, names[which],
               clEnqueueWriteBuffer(flight->queue, flight->buffer[which], CL_TRUE, 0, bytes, content, 0, NULL,
                                    NULL),
               err);
    return CML_OK;
}

/* All calls that were queued before have ended then. */
cml_status cml_opencl_flight_read(struct cml_opencl_flight *flight, int buffer, void *to, size_t bytes,
                                  struct cml_error *err)
{
    CML_CL(&flight->device, "reading results",
           clEnqueueReadBuffer(flight->queue, flight->buffer[buffer], CL_TRUE, 0, bytes, to, 0, NULL, NULL),
           err);
    return CML_OK;
}

/* Asks the device how it lays out the structs that both sides read, and fails unless sizes and offsets equal
 * the host's (kernels/device_layout.h). A compiler that aligns in another way would read the scene wrongly,
 * and nothing else would show it. The buffer of fates is free at this time, and serves for the answer. */
static cml_status check_layout(struct cml_opencl_flight *flight, struct cml_error *err)
{
    static const cml_u32 ours[CML_LAYOUT_ENTRIES] = CML_LAYOUT;
    const size_t one = 1;
    cml_u32 theirs[CML_LAYOUT_ENTRIES] = {0};
    cl_int code = CL_SUCCESS;
    CML_TRY(create_buffer(flight, CML_BUFFER_FATES, sizeof theirs, theirs, err));
    const cl_kernel kernel = clCreateKernel(flight->program, "cml_layout", &code);
    CML_CL(&flight->device, "the kernel cml_layout", code, err);
    code = clSetKernelArg(kernel, 0, sizeof(cl_mem), &flight->buffer[CML_BUFFER_FATES]);
    if (code == CL_SUCCESS)
        code = clEnqueueNDRangeKernel(flight->queue, kernel, 1, NULL, &one, &one, 0, NULL, NULL);
    clReleaseKernel(kernel);
    CML_CL(&flight->device, "the kernel cml_layout", code, err);
    CML_TRY(cml_opencl_flight_read(flight, CML_BUFFER_FATES, theirs, sizeof theirs, err));
    for (int i = 0; i < CML_LAYOUT_ENTRIES; i++)
        if (theirs[i] != ours[i])
            return cml_fail(
                err, CML_E_DEVICE,
                "opencl device %d (%s): layout entry %d is %u, on the host %u: its compiler lays out "
                "structs in another way",
                flight->device.number, flight->device.info.name, i, theirs[i], ours[i]);
    return CML_OK;
}

/* Marks all packets on the device as ended, so that work-items take new ones in the first call. */
static cml_status end_packets(struct cml_opencl_flight *flight, struct cml_error *err)
{
    const size_t count = (size_t)flight->most_items * flight->lanes, bytes = count * CML_DEVICE_PACKET;
    const int fate = CML_FATE_ABSORBED;
    CML_FREED char *packets = calloc(count, CML_DEVICE_PACKET);
    if (!packets) return cml_fail_memory(err, (double)bytes, "packets");
    for (size_t i = 0; i < count; i++)
        memcpy(packets + i * CML_DEVICE_PACKET + offsetof(struct cml_packet, fate), &fate, sizeof fate);
    return create_buffer(flight, CML_BUFFER_PACKETS, bytes, packets, err);
}

/* Sets all tallies of the device to 0. */
static cml_status zero_cells(struct cml_opencl_flight *flight, struct cml_error *err)
{
    const cl_ulong zero = 0;
    CML_CL(&flight->device, "memory for tallies",
           clEnqueueFillBuffer(flight->queue, flight->buffer[CML_BUFFER_CELLS], &zero, sizeof zero, 0,
                               flight->num_cells * sizeof zero, 0, NULL, NULL),
           err);
    return CML_OK;
}

/* Copies the scene to the device. Kernels only read the scene's arrays; counters and packets go on from call
 * to call. */
static cml_status create_buffers(const struct cml_opencl_scene *scene, struct cml_opencl_flight *flight,
                                 struct cml_error *err)
{
    const struct cml_owned_world *w = scene->world;
    const size_t bodies = (size_t)w->world.setup.num_bodies,
                 surfaces = (size_t)w->world.setup.num_layers + 1 + bodies,
                 sources = (size_t)w->world.setup.num_sources;
    const struct {
        int which;
        const void *content;
        size_t bytes;
    } arrays[] = {{CML_BUFFER_MEDIA, w->media, (surfaces + 1) * sizeof *w->media},
                  {CML_BUFFER_SURFACES, w->surfaces, surfaces * sizeof *w->surfaces},
                  {CML_BUFFER_RING_STARTS, w->ring_starts, w->num_rings * sizeof *w->ring_starts},
                  {CML_BUFFER_BODIES, w->bodies, bodies * sizeof *w->bodies},
                  {CML_BUFFER_BODY_NODES, w->body_nodes, w->num_body_nodes * sizeof *w->body_nodes},
                  {CML_BUFFER_BODY_GRIDS, w->body_grids, w->num_body_grids * sizeof *w->body_grids},
                  {CML_BUFFER_BODY_CELLS, w->body_cells, w->num_body_cells * sizeof *w->body_cells},
                  {CML_BUFFER_PHASE_CELLS, w->phase_cells, w->num_phase_cells * sizeof *w->phase_cells},
                  {CML_BUFFER_SOURCES, w->sources, sources * sizeof *w->sources},
                  {CML_BUFFER_LIGHT_CELLS, w->light_cells, w->num_light_cells * sizeof *w->light_cells},
                  {CML_BUFFER_IMAGE_WORDS, w->image_words, w->num_image_words * sizeof *w->image_words}};
    CML_TRY(create_buffer(flight, CML_BUFFER_COUNTERS, sizeof flight->counters, &flight->counters, err));
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        CML_TRY(create_buffer(flight, arrays[i].which, arrays[i].bytes, arrays[i].content, err));
    for (int row = 0; row < CML_RING_ROWS; row++)
        CML_TRY(create_buffer(flight, CML_BUFFER_RINGS + row, w->num_rings * sizeof *w->rings,
                              w->rings + (size_t)row * w->num_rings, err));
    for (int side = 0; side < 2; side++)
        CML_TRY(create_buffer(flight, CML_BUFFER_DEPTHS + side, w->depth_cells * sizeof *w->depths,
                              w->depths + (size_t)side * w->depth_cells, err));
    CML_TRY(create_buffer(flight, CML_BUFFER_CELLS, flight->num_cells * sizeof(uint64_t), NULL, err));
    CML_TRY(zero_cells(flight, err));
    return end_packets(flight, err);
}

/* Sets the kernel's arguments: 0, 1 and 2 are structs, then come the buffers in the order of their names,
 * then local memory. */
static cml_status set_arguments(const struct cml_opencl_scene *scene, const struct cml_local_parts *parts,
                                struct cml_opencl_flight *flight, struct cml_error *err)
{
    cl_int code = CL_SUCCESS;
    flight->kernel = clCreateKernel(flight->program, "cml_transport", &code);
    CML_CL(&flight->device, "the kernel cml_transport", code, err);
    code = clSetKernelArg(flight->kernel, 0, sizeof scene->world->world.setup, &scene->world->world.setup);
    if (code == CL_SUCCESS) code = clSetKernelArg(flight->kernel, 1, sizeof *parts, parts);
    for (cl_uint i = 0; code == CL_SUCCESS && i < CML_NUM_BUFFERS; i++)
        code = clSetKernelArg(flight->kernel, 3 + i, sizeof(cl_mem), &flight->buffer[i]);
    if (code == CL_SUCCESS)
        code = clSetKernelArg(flight->kernel, 3 + CML_NUM_BUFFERS, flight->call.num_local * sizeof(uint64_t),
                              NULL);
    CML_CL(&flight->device, "the kernel's arguments", code, err);
    return CML_OK;
}

/* Opens one device: sizes, context, queue, compiled kernel, buffers, arguments. Each step needs the ones
 * before it. On failure the caller releases what was made. */
static cml_status open_device(const struct cml_opencl_scene *scene, struct cml_opencl_flight *flight,
                              struct cml_error *err)
{
    const struct cml_opencl_device *device = &flight->device;
    cl_int code = CL_SUCCESS;
    choose_sizes(scene, flight);
    const struct cml_local_parts parts = lay_out_parts(scene, flight);
    CML_TRY(check_memory(flight, err));
    flight->context = clCreateContext(NULL, 1, &device->id, NULL, NULL, &code);
    CML_CL(device, "a context", code, err);
    flight->queue = clCreateCommandQueue(flight->context, device->id, 0, &code);
    CML_CL(device, "a queue", code, err);
    CML_TRY(build(scene, flight, err));
    CML_TRY(check_layout(flight, err));
    CML_TRY(create_buffers(scene, flight, err));
    return set_arguments(scene, &parts, flight, err);
}

cml_status cml_opencl_flight_open(const struct cml_opencl_device *device,
                                  const struct cml_opencl_scene *scene, struct cml_opencl_flight *flight,
                                  struct cml_error *err)
{
    *flight = (struct cml_opencl_flight){.device = *device};
    const cml_status status = open_device(scene, flight, err);
    if (status != CML_OK) cml_opencl_flight_close(flight);
    return status;
}

/* The flight may have been opened only in part. */
void cml_opencl_flight_close(struct cml_opencl_flight *flight)
{
    for (int i = 0; i < CML_NUM_BUFFERS; i++)
        if (flight->buffer[i]) clReleaseMemObject(flight->buffer[i]);
    if (flight->kernel) clReleaseKernel(flight->kernel);
    if (flight->program) clReleaseProgram(flight->program);
    if (flight->queue) clReleaseCommandQueue(flight->queue);
    if (flight->context) clReleaseContext(flight->context);
    *flight = (struct cml_opencl_flight){0};
}

/* With fewer photons than it could take, the device uses fewer work-items. The buffer for records of ends is
 * made when records are first wanted, and kept. */
cml_status cml_opencl_flight_begin(struct cml_opencl_flight *flight, uint64_t photons, uint64_t records,
                                   struct cml_error *err)
{
    flight->call.items = smaller((photons + flight->lanes - 1) / flight->lanes, flight->most_items);
    flight->call.record = records > 0;
    flight->counters = (struct cml_counters){0};
    if (records <= flight->fates) return CML_OK;
    CML_TRY(create_buffer(flight, CML_BUFFER_FATES, records * sizeof(struct cml_device_fate), NULL, err));
    flight->fates = records;
    CML_CL(&flight->device, "the kernel's arguments",
           clSetKernelArg(flight->kernel, 3 + CML_BUFFER_FATES, sizeof(cl_mem),
                          &flight->buffer[CML_BUFFER_FATES]),
           err);
    return CML_OK;
}

/* The next call writes the counters to the device. */
void cml_opencl_flight_give(struct cml_opencl_flight *flight, uint64_t first, uint64_t stride, uint64_t count)
{
    flight->counters.first = first;
    flight->counters.stride = stride;
    flight->counters.count = (uint32_t)count;
    flight->counters.taken = 0;
}

bool cml_opencl_flight_dry(const struct cml_opencl_flight *flight)
{
    return flight->counters.taken >= flight->counters.count;
}

bool cml_opencl_flight_done(const struct cml_opencl_flight *flight)
{
    return cml_opencl_flight_dry(flight) && flight->counters.alive == 0;
}

/* Only whole groups can be started; items beyond call.items rest. Counters go with every call, because the
 * device counts packets alive and lost. The flush makes the device begin while the host starts others. */
cml_status cml_opencl_flight_start(struct cml_opencl_flight *flight, struct cml_error *err)
{
    const size_t local = flight->group, global = (flight->call.items + local - 1) / local * local;
    flight->begin = cml_now();
    flight->counters.alive = 0;
    flight->counters.num_lost = 0;
    CML_CL(&flight->device, "the kernel's arguments",
           clSetKernelArg(flight->kernel, 2, sizeof flight->call, &flight->call), err);
    CML_CL(&flight->device, "writing counters",
           clEnqueueWriteBuffer(flight->queue, flight->buffer[CML_BUFFER_COUNTERS], CL_TRUE, 0,
                                sizeof flight->counters, &flight->counters, 0, NULL, NULL),
           err);
    CML_CL(&flight->device, "launching the kernel",
           clEnqueueNDRangeKernel(flight->queue, flight->kernel, 1, NULL, &global, &local, 0, NULL, NULL),
           err);
    CML_CL(&flight->device, "launching the kernel", clFlush(flight->queue), err);
    return CML_OK;
}

/* Adapts the number of steps of the next call to CALL_SECONDS: long enough that the host's part does not
 * count, short enough for watchdogs. Near its end a call has few packets left and is fast. With all items
 * busy it would have taken at most `full`. */
static void adapt(struct cml_opencl_flight *flight, double seconds)
{
    const uint32_t alive = flight->counters.alive, items = flight->call.items * flight->lanes;
    uint32_t *steps = &flight->call.steps;
    if (alive == 0) return;
    const double full = seconds * items / alive;
    if (full < CALL_SECONDS / 2 && *steps < MOST_STEPS) *steps *= 2;
    if (full > CALL_SECONDS * 2 && alive == items && *steps > 1) *steps /= 2;
}

/* The blocking read waits for the kernel, because the queue keeps its order. */
cml_status cml_opencl_flight_finish(struct cml_opencl_flight *flight, struct cml_error *err)
{
    CML_TRY(
        cml_opencl_flight_read(flight, CML_BUFFER_COUNTERS, &flight->counters, sizeof flight->counters, err));
    adapt(flight, cml_now() - flight->begin);
    return CML_OK;
}

cml_status cml_opencl_flight_collect(struct cml_opencl_flight *flight, uint64_t *cells, struct cml_error *err)
{
    CML_TRY(cml_opencl_flight_read(flight, CML_BUFFER_CELLS, cells, flight->num_cells * sizeof *cells, err));
    return zero_cells(flight, err);
}
