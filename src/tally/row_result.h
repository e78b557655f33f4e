/* Rows of a sweep that come of one flight (row_cells.h), each as a result of its own.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "tally/result.h"

/* Result of row 0..rows - 1 of a flight's, which is as a flight of its own would make it: *to is the caller's
 * to free. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_row_result(const struct cml_result *flight, int row, struct cml_result *to,
                                        struct cml_error *err);

/* The sums of weight times score number 0..rows - 1 (row_cells.h), by what became of the packets: totals but
 * Rsp, which is the flight's, what media absorb, and profiles over r and angle; all may be negative. *to is
 * the caller's to free. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_score_result(const struct cml_result *flight, int score, struct cml_result *to,
                                          struct cml_error *err);

/* How many packets of equal weight would tell a total as well as the result does: 1 / (relative error^2 + 1 /
 * photons); 0 of one that is 0. */
double cml_effective_packets(const struct cml_result *result, enum cml_total total);

/* The same of the sum of A_z, which comes of samples. */
double cml_effective_packets_by_depth(const struct cml_result *result);
