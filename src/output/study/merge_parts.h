/* What the merging of results shares. Private to merge*.c. SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_arrays.h"
#include "output/study/merge.h"

/* The words of a scene, without folders of files. */
CML_NODISCARD cml_status cml_merge_words(const struct cml_outcome *from, struct cml_outcome *merged,
                                         struct cml_error *err);

/* CML_E_INPUT: the first difference between two scenes or grids, or a seed that two have. */
CML_NODISCARD cml_status cml_merge_check(const struct cml_merge_input *inputs, int count,
                                         struct cml_error *err);

/* What a merged result is before it has values: the sizes, packets, seeds and words of all. *merged is zero,
 * and the caller's to clear, whatever happens. */
CML_NODISCARD cml_status cml_merge_head(const struct cml_merge_input *inputs, int count, const char *title,
                                        struct cml_outcome *merged, struct cml_error *err);

/* What the standard errors of input k count in those of the mean: its share of the packets. One packet has no
 * error of its own: it counts 0, and the others for it, as if it scattered like them. Where all count 0,
 * errors come from the spread between inputs (cml_merge_add_spread). */
double cml_merge_error_weight(const struct cml_merge_input *inputs, int count, int k);

/* Adds to squares[n] what one of `count` inputs of one packet adds to the variance of the mean. */
void cml_merge_add_spread(double *squares, const double *value, const double *mean, size_t n, int count);

/* Arrays that all inputs have, where these are .h5 files, as fields of their means. */
struct cml_merge_arrays {
    int num_files, count;
    struct cml_hdf5_arrays *file; /* [num_files] */
    double *weight;               /* [num_files] share of all photons */
    double *error_weight;         /* [num_files] cml_merge_error_weight */
    struct cml_merge_array *item; /* [count] where the fields' values come from */
    struct cml_field *field;      /* [count] */
    bool broken;                  /* an array could not be read, as err says */
    struct cml_error err;
};

/* Opens the arrays of all inputs; those of none where an input is no .h5 file. The caller closes them; on
 * failure nothing is left open. */
CML_NODISCARD cml_status cml_merge_arrays_open(const struct cml_merge_input *inputs, int count,
                                               const struct cml_outcome *merged,
                                               struct cml_merge_arrays *arrays, struct cml_error *err);
void cml_merge_arrays_close(struct cml_merge_arrays *arrays);
