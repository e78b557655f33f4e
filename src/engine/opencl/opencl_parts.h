/* What the files of the opencl engine share; the only file that includes OpenCL's header.
 * SPDX-License-Identifier: MIT */
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include "device_layout.h"
#include "engine/opencl/opencl.h"
#include "engine/world.h"

#include <stddef.h>

/* A device as OpenCL and as people know it. */
struct cml_opencl_device {
    int number; /* as `devices` counts */
    cl_device_id id;
    struct cml_opencl_info info;
};

/* The devices that `--device` names: "i", "i,j" or "all"; NULL: cml_opencl_default for the local rank. A
 * device may be named twice and then serves twice. CML_E_INPUT for what is no number, CML_E_DEVICE for a
 * device that is not there. */
CML_NODISCARD cml_status cml_opencl_select(const char *wanted, int local_rank,
                                           struct cml_opencl_device **list, int *count,
                                           struct cml_error *err);

/* "opencl device 0 (NAME): WHAT: CL_NAME_OF_CODE". Returns CML_E_DEVICE. */
CML_NODISCARD cml_status cml_opencl_fail(const struct cml_opencl_device *device, const char *what,
                                         cl_int code, struct cml_error *err);

/* Returns from the calling function when an OpenCL call fails. */
#define CML_CL(device, what, call, err)                                                                      \
    do {                                                                                                     \
        const cl_int cml_cl_code_ = (call);                                                                  \
        if (cml_cl_code_ != CL_SUCCESS) return cml_opencl_fail(device, what, cml_cl_code_, err);             \
    } while (0)

/* The kernel text, all headers in it, put together when the program was built. */
extern const char cml_opencl_text[];
extern const size_t cml_opencl_text_size;

typedef void cml_opencl_note(void *context, const char *text); /* as in cml_engine_options; NULL: silent */

/* Builds the kernel text for one device, or takes the binary that an earlier run left in the user's cache
 * directory. A compiler's complaint goes to standard error in full, its first line into err. */
CML_NODISCARD cml_status cml_opencl_program(const struct cml_opencl_device *device, cl_context context,
                                            const char *options, cml_opencl_note *on_note,
                                            cl_program *program, struct cml_error *err);

/* The cache of program binaries: one file per key, $XDG_CACHE_HOME/clustermcml or ~/.cache/clustermcml. A
 * file of another key, cut short or changed, is as good as none; so is, with a note, a file or a folder of
 * another user, or that others may write: what stands there is run. load returns NULL, else size bytes for
 * the caller to free; store says nothing when it fails. */
unsigned char *cml_opencl_cache_load(const char *key, cml_opencl_note *on_note, size_t *size);
void cml_opencl_cache_store(const char *key, const unsigned char *binary, size_t size);

/* What all devices are given of a scene; arrays are borrowed. */
struct cml_opencl_scene {
    const struct cml_owned_world *world;
    bool rough;                /* some boundary or body is */
    bool only_planes;          /* no curved boundaries and no bodies */
    uint64_t cells;            /* of A_l, Rd_ra, Tt_ra and A_rz together, which lie one behind the other */
    const char *build_options; /* NULL: none */
    cml_opencl_note *on_note;
    int group;           /* 0: chosen */
    bool loose_division; /* even where the device can round correctly */
};

/* Buffers of a device, in the order of the kernel's arguments. Those of the scene are written once; counters,
 * packets and cells live as long as the device is open. */
enum {
    CML_BUFFER_MEDIA,
    CML_BUFFER_SURFACES,
    CML_BUFFER_RINGS, /* the first of CML_RING_ROWS */
    CML_BUFFER_RING_STARTS = CML_BUFFER_RINGS + CML_RING_ROWS,
    CML_BUFFER_DEPTHS, /* the first of two */
    CML_BUFFER_BODIES = CML_BUFFER_DEPTHS + 2,
    CML_BUFFER_BODY_NODES,
    CML_BUFFER_BODY_GRIDS,
    CML_BUFFER_BODY_CELLS,
    CML_BUFFER_PHASE_CELLS,
    CML_BUFFER_SOURCES,
    CML_BUFFER_LIGHT_CELLS,
    CML_BUFFER_IMAGE_WORDS,
    CML_BUFFER_COUNTERS, /* counters that host and device pass to and fro, struct cml_counters */
    CML_BUFFER_PACKETS,  /* packets under way, from call to call */
    CML_BUFFER_FATES,    /* records, where they are wanted */
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
    uint64_t num_cells;                /* of the block */
    uint32_t group, most_items, lanes; /* lanes: packets of a work-item */
    size_t fates;                      /* records that its buffer has room for */
    struct cml_kernel_call call;
    struct cml_counters counters;
    double begin; /* of the call under way, s */
};

/* On failure everything is released. */
CML_NODISCARD cml_status cml_opencl_flight_open(const struct cml_opencl_device *device,
                                                const struct cml_opencl_scene *scene,
                                                struct cml_opencl_flight *flight, struct cml_error *err);
void cml_opencl_flight_close(struct cml_opencl_flight *flight);

/* Readies the device for about `photons` packets; records are wanted of so many. */
CML_NODISCARD cml_status cml_opencl_flight_begin(struct cml_opencl_flight *flight, uint64_t photons,
                                                 uint64_t records, struct cml_error *err);

/* Hands over indices; only when it has taken all earlier ones. */
void cml_opencl_flight_give(struct cml_opencl_flight *flight, uint64_t first, uint64_t stride,
                            uint64_t count);
bool cml_opencl_flight_dry(const struct cml_opencl_flight *flight);  /* has taken all its indices */
bool cml_opencl_flight_done(const struct cml_opencl_flight *flight); /* and no packet is under way */

/* One call of the kernel: start returns at once, finish waits, reads the counters and adapts the next call's
 * length. */
CML_NODISCARD cml_status cml_opencl_flight_start(struct cml_opencl_flight *flight, struct cml_error *err);
CML_NODISCARD cml_status cml_opencl_flight_finish(struct cml_opencl_flight *flight, struct cml_error *err);

/* Reads one buffer from its start. */
CML_NODISCARD cml_status cml_opencl_flight_read(struct cml_opencl_flight *flight, int buffer, void *to,
                                                size_t bytes, struct cml_error *err);

/* Reads the block of cells (num_cells) and zeroes it on the device. */
CML_NODISCARD cml_status cml_opencl_flight_collect(struct cml_opencl_flight *flight, uint64_t *cells,
                                                   struct cml_error *err);
