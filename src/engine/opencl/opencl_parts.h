/* Types and functions that the files of the opencl engine share. This is the only file that includes OpenCL's
 * header.
 * SPDX-License-Identifier: MIT */
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include "device_layout.h"
#include "engine/opencl/opencl.h"
#include "engine/world.h"

#include <stddef.h>

/* A device with its handle and its description. */
struct cml_opencl_device {
    int number; /* number of the device, as `devices` counts */
    cl_device_id id;
    struct cml_opencl_info info;
};

/* Finds the devices that `--device` names: "i", "i,j" or "all"; NULL: cml_opencl_default for the local rank.
 * A device that is named twice serves twice. CML_E_INPUT: a word is no number. CML_E_DEVICE: there is no such
 * device. */
CML_NODISCARD cml_status cml_opencl_select(const char *wanted, int local_rank,
                                           struct cml_opencl_device **list, int *count,
                                           struct cml_error *err);

/* Fails with "opencl device 0 (NAME): WHAT: CL_NAME_OF_CODE". Returns CML_E_DEVICE. */
CML_NODISCARD cml_status cml_opencl_fail(const struct cml_opencl_device *device, const char *what,
                                         cl_int code, struct cml_error *err);

/* Returns from the calling function if an OpenCL call fails. */
#define CML_CL(device, what, call, err)                                                                      \
    do {                                                                                                     \
        const cl_int cml_cl_code_ = (call);                                                                  \
        if (cml_cl_code_ != CL_SUCCESS) return cml_opencl_fail(device, what, cml_cl_code_, err);             \
    } while (0)

/* The text of the kernel with all its headers, put together when the program was built. */
extern const char cml_opencl_text[];
extern const size_t cml_opencl_text_size;

/* Takes a note for people, as in cml_engine_options; NULL: silent. */
typedef void cml_opencl_note(void *context, const char *text);

/* Builds the kernel text for one device, or takes the binary that an earlier run left in the user's cache
 * directory. The compiler's log goes to standard error in full, its first line that names an error into
 * err. */
CML_NODISCARD cml_status cml_opencl_program(const struct cml_opencl_device *device, cl_context context,
                                            const char *options, cml_opencl_note *on_note,
                                            cl_program *program, struct cml_error *err);

/* The cache of program binaries, in $XDG_CACHE_HOME/clustermcml or ~/.cache/clustermcml, one file for each
 * key. load returns a binary of `size` bytes, which the caller frees, or NULL. A file of another key, cut
 * short or changed, counts as missing. So does, with a note, a file or folder of another user, or that others
 * may write, because its content would be run. store reports no failure. */
unsigned char *cml_opencl_cache_load(const char *key, cml_opencl_note *on_note, size_t *size);
void cml_opencl_cache_store(const char *key, const unsigned char *binary, size_t size);

/* The parts of a scene that all devices get. Arrays are borrowed. */
struct cml_opencl_scene {
    const struct cml_owned_world *world;
    bool rough;       /* some boundary or body is rough */
    bool only_planes; /* the scene has no curved boundaries and no bodies */
    /* Cells of A_l, Rd_ra, Tt_ra and A_rz together, which lie one behind the other. */
    uint64_t cells;
    const char *build_options; /* options for the device's compiler; NULL: none */
    cml_opencl_note *on_note;
    int group;           /* work-items per group; 0: chosen by the device */
    bool loose_division; /* true: even if the device can round division correctly */
};

/* Buffers of a device, in the order of the kernel's arguments. The scene's buffers are written once.
 * Counters, packets and cells live as long as the device is open. */
enum {
    CML_BUFFER_MEDIA,
    CML_BUFFER_SURFACES,
    CML_BUFFER_RINGS, /* the first of CML_RING_ROWS arrays of rings */
    CML_BUFFER_RING_STARTS = CML_BUFFER_RINGS + CML_RING_ROWS,
    CML_BUFFER_DEPTHS, /* the first of two: deepest and highest */
    CML_BUFFER_BODIES = CML_BUFFER_DEPTHS + 2,
    CML_BUFFER_BODY_NODES,
    CML_BUFFER_BODY_GRIDS,
    CML_BUFFER_BODY_CELLS,
    CML_BUFFER_PHASE_CELLS,
    CML_BUFFER_SOURCES,
    CML_BUFFER_LIGHT_CELLS,
    CML_BUFFER_IMAGE_WORDS,
    CML_BUFFER_COUNTERS, /* struct cml_counters, passed to and fro between host and device */
    CML_BUFFER_PACKETS,  /* packets under way, kept from call to call */
    CML_BUFFER_FATES,    /* records of packets, if they are wanted */
    CML_BUFFER_CELLS,    /* all tallies */
    CML_NUM_BUFFERS
};

/* One device in use. */
struct cml_opencl_flight {
    struct cml_opencl_device device;
    cl_context context;
    cl_command_queue queue;
    cl_program program;
    cl_kernel kernel;
    cl_mem buffer[CML_NUM_BUFFERS];
    uint64_t num_cells;                /* number of cells in the block of tallies */
    uint32_t group, most_items, lanes; /* work-items of a group; most work-items; packets of a work-item */
    size_t fates;                      /* records that the buffer of fates has room for */
    struct cml_kernel_call call;
    struct cml_counters counters;
    double begin; /* time when the call under way began, s */
};

/* Opens a device for a scene. On failure everything is released. */
CML_NODISCARD cml_status cml_opencl_flight_open(const struct cml_opencl_device *device,
                                                const struct cml_opencl_scene *scene,
                                                struct cml_opencl_flight *flight, struct cml_error *err);
void cml_opencl_flight_close(struct cml_opencl_flight *flight);

/* Readies the device for about `photons` packets, and for the records of `records` packets. */
CML_NODISCARD cml_status cml_opencl_flight_begin(struct cml_opencl_flight *flight, uint64_t photons,
                                                 uint64_t records, struct cml_error *err);

/* Gives the device `count` photons, from index `first` on, `stride` apart. Only allowed when it has taken all
 * earlier ones. */
void cml_opencl_flight_give(struct cml_opencl_flight *flight, uint64_t first, uint64_t stride,
                            uint64_t count);
/* True if the device has taken all its photons. */
bool cml_opencl_flight_dry(const struct cml_opencl_flight *flight);
/* True if the device has taken all its photons, and no packet is under way. */
bool cml_opencl_flight_done(const struct cml_opencl_flight *flight);

/* One call of the kernel. start returns at once. finish waits, reads the counters and adapts the length of
 * the next call. */
CML_NODISCARD cml_status cml_opencl_flight_start(struct cml_opencl_flight *flight, struct cml_error *err);
CML_NODISCARD cml_status cml_opencl_flight_finish(struct cml_opencl_flight *flight, struct cml_error *err);

/* Reads one buffer from its start. */
CML_NODISCARD cml_status cml_opencl_flight_read(struct cml_opencl_flight *flight, int buffer, void *to,
                                                size_t bytes, struct cml_error *err);

/* Reads the block of cells (num_cells) and sets it to zero on the device. */
CML_NODISCARD cml_status cml_opencl_flight_collect(struct cml_opencl_flight *flight, uint64_t *cells,
                                                   struct cml_error *err);
