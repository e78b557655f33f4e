/* The OpenCL devices of this machine, in the order in which the platforms report them: their numbers are what
 * `--device` means. Known without any OpenCL header; built without OpenCL there is none.
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
    uint64_t largest;      /* bytes of one allocation at most */
    uint64_t local_memory; /* bytes a work-group has */
    unsigned largest_group;
    bool atomics64;      /* cl_khr_int64_base_atomics */
    bool exact_division; /* division and square root are correctly rounded, as on the CPU */
};

/* All devices; *list is the caller's to free. No platform at all is an empty list, not an error. */
CML_NODISCARD cml_status cml_opencl_list(struct cml_opencl_info **list, int *count, struct cml_error *err);

/* What the program was built against, for people: "OpenCL, ..." or "none". */
const char *cml_opencl_build(void);

/* Which device without `--device`: the one with the number of this process among those on its machine,
 * counted round the GPUs, or round all devices where there is no GPU. list[count], count > 0. */
int cml_opencl_default(const struct cml_opencl_info *list, int count, int local_rank);
