/* The environment that a launcher (mpiexec, srun) or a batch system gave this process: other ranks, and
 * cores. Environment variables tell whether there is a launcher, because MPI_Init costs a plain start one
 * second, and fails in a batch script. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>

/* True under the mpiexec of Open MPI, MPICH or Intel MPI, and under srun with a PMI or PMIx plugin. */
bool cml_launcher_found(void);

/* Returns how many processes the launcher says it started; 1 when it says nothing. cml_launcher_rank: the
 * number of this process among them, without MPI; 0 when the launcher says nothing. */
int cml_launcher_size(void);
int cml_launcher_rank(void);

/* Fails with CML_E_INPUT when the launcher started several processes of which each sees only itself: they
 * would write the same files. size: how many processes see each other; 1 without MPI, as under srun without a
 * plugin. why: why the processes do not see each other, for the message; NULL: unknown. */
CML_NODISCARD cml_status cml_launcher_check(int size, const char *why, struct cml_error *err);

struct cml_cores {
    unsigned char bits[128]; /* one bit per core, so that masks of several processes can be joined by or */
};

/* Returns all cores that threads of this process may run on, even if OpenMP bound the calling thread to few.
 * Empty when the system does not tell. */
void cml_cores_mine(struct cml_cores *cores);

/* Returns the number of cores in a mask. */
int cml_cores_count(const struct cml_cores *cores);
