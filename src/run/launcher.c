/* SPDX-License-Identifier: MIT */
#include "run/launcher.h"

#include "base/text.h"

#include <stdlib.h>

/* OMPI_COMM_WORLD_SIZE: Open MPI; PMI_RANK: MPICH, Intel MPI, srun --mpi=pmi2; PMIX_RANK: srun --mpi=pmix. */
bool cml_launcher_found(void)
{
    static const char *const names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_RANK", "PMIX_RANK", NULL};
    for (int i = 0; names[i]; i++)
        if (getenv(names[i])) return true;
    return false;
}

/* How many processes the launcher says it started; 1 when it says nothing. Within a batch script, outside of
 * srun, Slurm sets SLURM_NTASKS but no SLURM_STEP_NUM_TASKS. */
static int number_started(const char **variable)
{
    static const char *const names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS", NULL};
    for (int i = 0; names[i]; i++) {
        const char *value = getenv(names[i]);
        int number = 0;
        *variable = names[i];
        if (value && cml_parse_int(value, &number) && number > 1) return number;
    }
    return 1;
}

cml_status cml_launcher_check(int size, struct cml_error *err)
{
    const char *variable = NULL;
    const int started = number_started(&variable);
    if (size > 1 || started == 1) return CML_OK;
    return cml_fail(
        err, CML_E_INPUT,
        "%s = %d processes were started, but each sees only itself (expected this program built with "
        "MPI and the launcher of the same MPI, or srun --mpi=pmix)",
        variable, started);
}
