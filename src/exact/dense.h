/* Dense matrices of double, row by row, as few operations as adding-doubling needs. Knows no light.
 * SPDX-License-Identifier: MIT */
#ifndef CML_DENSE_H
#define CML_DENSE_H

/* c += a b. a, c: [rows][n]; b: [n][n]; c overlaps neither. */
void cml_dense_add_product(int rows, int n, const double *a, const double *b, double *c);

/* b <- b a^-1. a: [n][n], destroyed; b: [rows][n]. Elimination without pivots: each column of a must be
 * dominated by its diagonal, as it is in 1 - M where M turns power into no more power. Where a is singular b
 * becomes infinite or no number. */
void cml_dense_divide(int rows, int n, double *a, double *b);

#endif
