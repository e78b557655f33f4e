/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* sched_getaffinity */
#include "cores.h"

#include <sched.h>
#include <string.h>

_Static_assert(sizeof(cpu_set_t) == sizeof(struct cml_cores), "a mask of 1024 cores");

void cml_cores_mine(struct cml_cores *cores)
{
    cpu_set_t mask;
    CPU_ZERO(&mask);
    sched_getaffinity(0, sizeof mask, &mask);
    memcpy(cores, &mask, sizeof *cores);
}

int cml_cores_count(const struct cml_cores *cores)
{
    int count = 0;
    for (unsigned i = 0; i < 8 * sizeof cores->bits; i++) count += cores->bits[i / 8] >> i % 8 & 1;
    return count;
}
