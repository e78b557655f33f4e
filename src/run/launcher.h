/* What a launcher (mpiexec, srun) or a batch system gave this process: company, and cores.
 * Whether there is a launcher is judged by the environment, because MPI_Init costs a plain start a second,
 * and fails in a batch script. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>

/* True under Open MPI's, MPICH's and Intel's mpiexec, and under srun with a PMI or PMIx plugin. */
bool cml_launcher_found(void);

/* CML_E_INPUT when the launcher started several processes of which each sees only itself: they would write
 * the same files. `size` is how many see each other: 1 without MPI, as under srun without a plugin. */
CML_NODISCARD cml_status cml_launcher_check(int size, struct cml_error *err);

struct cml_cores {
    unsigned char bits[128]; /* one bit per core: masks of several processes can be joined by or */
};

/* All cores that threads of this process may run on, wherever OpenMP bound the calling one; empty when the
 * system does not tell. */
void cml_cores_mine(struct cml_cores *cores);

/* Number of cores in a mask. */
int cml_cores_count(const struct cml_cores *cores);
