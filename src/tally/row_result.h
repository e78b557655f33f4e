/* Makes results of their own from the rows of a sweep that come from one flight (row_cells.h).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "tally/result.h"

/* Makes the result of row 0..rows - 1 of a flight, as if the row had been flown by itself. The caller frees
 * *to. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_row_result(const struct cml_result *flight, int row, struct cml_result *to,
                                        struct cml_error *err);

/* Makes the sums of weight times score number 0..rows - 1 (row_cells.h): totals except Rsp, which is the
 * flight's, absorption by medium, and profiles over r and angle. All may be negative. The caller frees *to.
 * CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_score_result(const struct cml_result *flight, int score, struct cml_result *to,
                                          struct cml_error *err);

/* Returns 1 / (relative error^2 + 1 / photons) of a total, which says how many packets of equal weight would
 * give the total as precisely. Returns 0 if the total is 0. */
double cml_effective_packets(const struct cml_result *result, enum cml_total total);

/* Returns the number of packets of equal weight that would give the sum of A_z as precisely as the result
 * does. A_z comes from samples of the interactions. */
double cml_effective_packets_by_depth(const struct cml_result *result);
