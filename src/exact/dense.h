/* Dense matrices of double, stored row by row, with the few operations that adding-doubling needs. Knows no
 * light. SPDX-License-Identifier: MIT */
#pragma once

/* A kind of square matrices [n][n]: a few rows are full, all others are 0 beside the diagonal. Products and
 * quotients of matrices of one kind are of that kind, too.
 *
 *     x x x x x   full row
 *     0 x 0 0 0
 *     x x x x x   full row
 *     0 0 0 x 0
 *     0 0 0 0 x */
struct cml_dense_kind {
    int n, num_full;
    const int *full; /* [num_full] numbers of the full rows, rising */
};

/* Adds the product a b to c, which overlaps neither. a, c: [n + more][n], where the last `more` rows are
 * arbitrary; b: [n][n]. */
void cml_dense_add_product(const struct cml_dense_kind *kind, int more, const double *a, const double *b,
                           double *c);

/* Adds the product a b of arbitrary matrices to c, which overlaps neither. a: [rows][middle], b:
 * [middle][columns]. */
void cml_dense_add_general(int rows, int middle, int columns, const double *a, const double *b, double *c);

/* Adds the product of an arbitrary row a and the matrix b to the row c. a, c: [n]. */
void cml_dense_add_row_product(const struct cml_dense_kind *kind, const double *a, const double *b,
                               double *c);

/* Replaces b by b a^-1. a: [n][n], destroyed; b: [n + more][n]. Elimination without pivots: each column of a
 * must be dominated by its diagonal, as in 1 - M where M does not increase power. If a is singular, b becomes
 * infinite or NAN. */
void cml_dense_divide(const struct cml_dense_kind *kind, int more, double *a, double *b);
