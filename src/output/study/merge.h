/* Several results of one scene, flown with different seeds, as one: the mean over all their packets.
 * A value is the mean of the values, weighted by packets; its error, as runs with different seeds are
 * independent, the root of the sum of squares of the weighted errors. SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_file.h"
#include "result/outcome.h"

#include <stdio.h>

/* A result that is there, and the path of its file. Borrowed. */
struct cml_merge_input {
    const char *name;
    const struct cml_outcome *outcome;
};

/* Merges count >= 2 results into *merged, with the errors, books and seeds of all. CML_E_INPUT: a
 * result of another scene or grid, with the first difference; one without standard errors; a seed and run
 * that two of them share. The caller clears *merged, which is empty after a failure. */
CML_NODISCARD cml_status cml_merge(const struct cml_merge_input *inputs, int count, const char *title,
                                   struct cml_outcome *merged, struct cml_error *err);

/* The names of what some of these inputs have and their merged result has not, with commas; NULL: nothing,
 * else the caller's to free. CML_E_INPUT: out of memory. */
CML_NODISCARD cml_status cml_merge_left_out(const struct cml_merge_input *inputs, int count,
                                            const struct cml_outcome *merged, char **names,
                                            struct cml_error *err);

/* Writes the result that cml_merge has made of these inputs as .h5: what an .mco file holds, under the names
 * of a run's .h5, and where all inputs are .h5 files the means of all else that they hold: maps, volumes,
 * facets. Atomic; CML_E_IO, and CML_E_INPUT when an input cannot be read. */
CML_NODISCARD cml_status cml_merge_write_h5(const char *path, const struct cml_outcome *merged,
                                            const struct cml_merge_input *inputs, int count,
                                            const struct cml_hdf5_call *call, struct cml_error *err);

/* Of joined files of saved packets: rows, packets that were to be rows, and packets of which no row is
 * missing (cml_saved_covers); the sum of the limits. */
struct cml_merge_saved {
    double rows, found, covers, limit, detected;
};

/* Joins files of saved packets of one scene, count >= 2, whose outcomes are heads (cml_h5_read_head): the
 * rows of each behind those of the one before, with an array `result` that says of which they are. Atomic;
 * CML_E_IO, CML_E_INPUT as cml_merge, and for files that differ in what they hold. The caller clears *merged,
 * which is empty after a failure. */
CML_NODISCARD cml_status cml_merge_saved(const char *path, const struct cml_merge_input *inputs, int count,
                                         const struct cml_hdf5_call *call, struct cml_outcome *merged,
                                         struct cml_merge_saved *saved, struct cml_error *err);

/* One object on one line: output, inputs, photons, rows, found, covers. */
CML_NODISCARD cml_status cml_merge_saved_json(FILE *stream, const char *path,
                                              const struct cml_merge_input *inputs, int count,
                                              const struct cml_outcome *merged,
                                              const struct cml_merge_saved *saved, struct cml_error *err);

/* How many totals of a merged result are known with their errors, in the order of enum cml_total. */
int cml_merged_totals(const struct cml_outcome *merged);

/* One object on one line: output, inputs, photons, totals and their errors. */
CML_NODISCARD cml_status cml_merge_json(FILE *stream, const char *path, const struct cml_merge_input *inputs,
                                        int count, const struct cml_outcome *merged, struct cml_error *err);
