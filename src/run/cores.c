/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* sched_getaffinity */
#include "run/cores.h"

#include <omp.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(sizeof(cpu_set_t) == sizeof(struct cml_cores), "a mask of 1024 cores");

static void add_core(struct cml_cores *cores, int core)
{
    const size_t bit = (size_t)core;
    if (core >= 0 && bit < 8 * sizeof cores->bits) cores->bits[bit / 8] |= (unsigned char)(1u << bit % 8);
}

static void add_place(struct cml_cores *cores, int place)
{
    const int count = omp_get_place_num_procs(place);
    int *ids = count > 0 ? calloc((size_t)count, sizeof *ids) : NULL;
    if (!ids) return;
    omp_get_place_proc_ids(place, ids);
    for (int i = 0; i < count; i++) add_core(cores, ids[i]);
    free(ids);
}

/* Where OpenMP binds threads (OMP_PROC_BIND, OMP_PLACES) it has bound the main one before main() begins, and
 * only its places tell what the process may use. */
void cml_cores_mine(struct cml_cores *cores)
{
    cpu_set_t mask;
    CPU_ZERO(&mask);
    sched_getaffinity(0, sizeof mask, &mask);
    memcpy(cores, &mask, sizeof *cores);
    for (int place = 0; place < omp_get_num_places(); place++) add_place(cores, place);
}

int cml_cores_count(const struct cml_cores *cores)
{
    int count = 0;
    for (unsigned i = 0; i < 8 * sizeof cores->bits; i++) count += cores->bits[i / 8] >> i % 8 & 1;
    return count;
}
