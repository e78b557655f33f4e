/* The OpenCL devices of this machine, in the order in which the platforms report them; `--device` takes their
 * numbers. This header needs no OpenCL header. A program built without OpenCL has no device.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

struct cml_opencl_info {
    char name[128], vendor[64], platform[96], version[96], driver[96];
    const char *type;      /* "GPU", "CPU" or "other" */
    unsigned units;        /* compute units */
    uint64_t memory;       /* bytes of global memory */
    uint64_t largest;      /* largest allocation, bytes */
    uint64_t local_memory; /* memory of a work-group, bytes */
    unsigned largest_group;
    bool atomics64;      /* has 64-bit atomic additions (cl_khr_int64_base_atomics) */
    bool exact_division; /* 1: division and square root are correctly rounded, as on the CPU */
};

/* Lists all devices; the caller frees *list. Without any platform the list is empty, and that is no error. */
CML_NODISCARD cml_status cml_opencl_list(struct cml_opencl_info **list, int *count, struct cml_error *err);

/* Returns a text for people that says against what the program was built: "OpenCL, ..." or "none". */
const char *cml_opencl_build(void);

/* Returns the device that is used without `--device`: the one with the number of this process among the
 * processes on its machine, counted round the GPUs, or round all devices if there is no GPU. list[count],
 * count > 0. */
int cml_opencl_default(const struct cml_opencl_info *list, int count, int local_rank);
