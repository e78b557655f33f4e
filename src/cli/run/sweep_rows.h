/* Who flies which row of a sweep, and how what came of it gets to rank 0. SPDX-License-Identifier: MIT */
#pragma once

#include "run/checkpoint.h"

/* Zeroed: none. */
struct cml_sweep_rows {
    int count, num_done;       /* num_done: rank 0's */
    bool *done;                /* [count] flown by this rank; on rank 0 at the end by any */
    struct cml_record *record; /* [count] of those, without json at the end */
};

CML_NODISCARD cml_status cml_sweep_rows_create(int count, struct cml_sweep_rows *rows, struct cml_error *err);
void cml_sweep_rows_clear(struct cml_sweep_rows *rows);

/* Prints the objects of all rows on rank 0, in their order, and frees them. */
void cml_sweep_rows_print(struct cml_sweep_rows *rows, bool json);

/* Flies a row, on all ranks or, where they share rows, on this one alone, which is then the only rank and
 * rank 0 (cml_cluster_alone). *record is filled when it returns CML_OK or CML_E_NUMERIC. */
typedef cml_status cml_sweep_fly_function(void *context, int row, struct cml_record *record,
                                          struct cml_error *err);

/* Flies all rows: one after the other on all ranks; but where there are more rows than ranks, each rank takes
 * the next one when it has done its last. json: rank 0 prints the objects of rows, in their order in the end.
 * Ends early with the status of what went wrong, or with CML_E_STOPPED; with CML_E_NUMERIC when all are flown
 * and one is not to be trusted. Collective. */
CML_NODISCARD cml_status cml_sweep_rows_fly(struct cml_sweep_rows *rows, bool json,
                                            cml_sweep_fly_function *fly, void *context,
                                            struct cml_error *err);
