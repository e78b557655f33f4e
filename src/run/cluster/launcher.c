/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* for sched_getaffinity */
#include "run/cluster/launcher.h"

#include "base/text.h"

#include <omp.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

/* True if an MPI launcher has started this process. Open MPI sets OMPI_COMM_WORLD_SIZE; MPICH, Intel MPI and
 * srun --mpi=pmi2 set PMI_RANK; srun --mpi=pmix sets PMIX_RANK. */
bool cml_launcher_found(void)
{
    static const char *const names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_RANK", "PMIX_RANK", NULL};
    for (int i = 0; names[i]; i++)
        if (getenv(names[i])) return true;
    return false;
}

/* The environment variables of each launcher: number of processes, and number of this process. In a batch
 * script, outside of srun, Slurm sets SLURM_NTASKS but not SLURM_STEP_NUM_TASKS. */
static const struct said {
    const char *size, *rank;
} said[] = {{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"},
            {"PMI_SIZE", "PMI_RANK"},
            {"SLURM_STEP_NUM_TASKS", "SLURM_PROCID"}};

/* Returns the number in an environment variable, or `otherwise`. */
static int number_in(const char *variable, int otherwise)
{
    const char *value = getenv(variable);
    int number = 0;
    return value && cml_parse_int(value, &number) ? number : otherwise;
}

/* Returns the variables of the launcher that started several processes. NULL: none says so. */
static const struct said *several(void)
{
    for (size_t i = 0; i < sizeof said / sizeof *said; i++)
        if (number_in(said[i].size, 1) > 1) return &said[i];
    return NULL;
}

int cml_launcher_size(void)
{
    const struct said *by = several();
    return by ? number_in(by->size, 1) : 1;
}

int cml_launcher_rank(void)
{
    const struct said *by = several();
    return by ? number_in(by->rank, 0) : 0;
}

/* Refuses a single rank if the launcher started several processes: each of them would fly the whole run. A
 * process that was started alone, or by a batch script without srun, is one rank. */
cml_status cml_launcher_check(int size, const char *why, struct cml_error *err)
{
    const struct said *by = several();
    if (size > 1 || !by) return CML_OK;
    if (!why)
        why = "each sees only itself (expected the launcher of the MPI library that this program uses, or "
              "srun --mpi=pmix)";
    return cml_fail(
        err, CML_E_INPUT,
        "a launcher started %d processes (%s=%d), but %s; to fly in one process: env -u %s clustermcml ...",
        number_in(by->size, 1), by->size, number_in(by->size, 1), why, by->size);
}

/* ---- cores ---- */

_Static_assert(sizeof(cpu_set_t) == sizeof(struct cml_cores), "a mask of 1024 cores");

/* Adds a core to the mask. Cores beyond 1024 are left out: cpu_set_t has no place for them either. */
static void add_core(struct cml_cores *cores, int core)
{
    const size_t bit = (size_t)core;
    if (core >= 0 && bit < 8 * sizeof cores->bits) cores->bits[bit / 8] |= (unsigned char)(1u << bit % 8);
}

/* Adds the cores of a place, the set of cores that OpenMP binds a thread to. Without memory for their numbers
 * the place is left out. */
static void add_place(struct cml_cores *cores, int place)
{
    const int count = omp_get_place_num_procs(place);
    int *ids = count > 0 ? calloc((size_t)count, sizeof *ids) : NULL;
    if (!ids) return;
    omp_get_place_proc_ids(place, ids);
    for (int i = 0; i < count; i++) add_core(cores, ids[i]);
    free(ids);
}

/* Asks OpenMP's places, too: with OMP_PROC_BIND or OMP_PLACES the main thread is bound before main() begins,
 * and only the places tell which cores the process may use. */
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
