/* Deals the rows of a sweep out to ranks, and brings their records to rank 0. SPDX-License-Identifier: MIT */
#pragma once

#include "run/checkpoint.h"

/* The rows of a sweep. A struct of zeros has none. */
struct cml_sweep_rows {
    int count, num_done;       /* num_done: rows flown by all ranks, on rank 0 only */
    bool *done;                /* [count] flown by this rank; on rank 0 in the end: flown by any rank */
    struct cml_record *record; /* [count] records of rows flown, in the end without JSON */
};

CML_NODISCARD cml_status cml_sweep_rows_create(int count, struct cml_sweep_rows *rows, struct cml_error *err);
void cml_sweep_rows_clear(struct cml_sweep_rows *rows);

/* Prints the JSON objects of all rows on rank 0, in the order of rows, and frees them. */
void cml_sweep_rows_print(struct cml_sweep_rows *rows, bool json);

/* Flies a row: on all ranks; or, if ranks share the rows, on this rank alone, which then is rank 0 of 1
 * (cml_cluster_alone). *record is filled for CML_OK and CML_E_NUMERIC. */
typedef cml_status cml_sweep_fly_function(void *context, int row, struct cml_record *record,
                                          struct cml_error *err);

/* Flies all rows: one after the other on all ranks; or, if there are more rows than ranks, each rank takes
 * the next row when it has finished one. json: rank 0 prints the objects of rows, in the order of rows. Ends
 * early with the status of a failure, or with CML_E_STOPPED. CML_E_NUMERIC: all are flown, and one cannot be
 * trusted. Collective. */
CML_NODISCARD cml_status cml_sweep_rows_fly(struct cml_sweep_rows *rows, bool json,
                                            cml_sweep_fly_function *fly, void *context,
                                            struct cml_error *err);
