/* Matrices of double, row by row, as few operations as adding-doubling needs. Knows no light.
 * SPDX-License-Identifier: MIT */
#pragma once

/* Square matrices [n][n] of one kind: all rows but these are 0 beside the diagonal. Products and quotients of
 * a kind are of that kind, too. */
struct cml_dense_kind {
    int n, num_full;
    const int *full; /* [num_full] rising */
};

/* c += a b. a, c: [n + more][n], with `more` rows of any numbers; b: [n][n]; c overlaps neither. */
void cml_dense_add_product(const struct cml_dense_kind *kind, int more, const double *a, const double *b,
                           double *c);

/* c += a b of any matrices. a: [rows][middle], b: [middle][columns]. c overlaps neither. */
void cml_dense_add_general(int rows, int middle, int columns, const double *a, const double *b, double *c);

/* c += a b of one row of any numbers. a, c: [n]. */
void cml_dense_add_row_product(const struct cml_dense_kind *kind, const double *a, const double *b,
                               double *c);

/* b <- b a^-1. a: [n][n], destroyed; b: [n + more][n]. Elimination without pivots: each column of a must be
 * dominated by its diagonal, as it is in 1 - M where M turns power into no more power. Where a is singular b
 * becomes infinite or no number. */
void cml_dense_divide(const struct cml_dense_kind *kind, int more, double *a, double *b);
