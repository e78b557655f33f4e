/* SPDX-License-Identifier: MIT */
#include "exact/dense.h"

#include <stddef.h>

/* Four rows of b at once: c is read and written a quarter as often. */
static void add_row_product(int n, const double *restrict a, const double *restrict b, double *restrict c)
{
    int k = 0;
    for (; k + 4 <= n; k += 4) {
        const double *b0 = b + (size_t)k * (size_t)n, *b1 = b0 + n, *b2 = b1 + n, *b3 = b2 + n;
        const double a0 = a[k], a1 = a[k + 1], a2 = a[k + 2], a3 = a[k + 3];
        for (int j = 0; j < n; j++) c[j] += (a0 * b0[j] + a1 * b1[j]) + (a2 * b2[j] + a3 * b3[j]);
    }
    for (; k < n; k++)
        for (int j = 0; j < n; j++) c[j] += a[k] * b[(size_t)k * (size_t)n + (size_t)j];
}

void cml_dense_add_product(int rows, int n, const double *a, const double *b, double *c)
{
    for (int i = 0; i < rows; i++)
        add_row_product(n, a + (size_t)i * (size_t)n, b, c + (size_t)i * (size_t)n);
}

/* to[j] -= factor from[j], first <= j < end */
static void subtract(double factor, const double *restrict from, double *restrict to, int first, int end)
{
    for (int j = first; j < end; j++) to[j] -= factor * from[j];
}

/* a becomes L (below the diagonal, which is 1) and U. */
static void factorise(int n, double *a)
{
    for (int k = 0; k < n; k++)
        for (int i = k + 1; i < n; i++) {
            a[i * n + k] /= a[k * n + k];
            subtract(a[i * n + k], a + k * n, a + i * n, k + 1, n);
        }
}

void cml_dense_divide(int rows, int n, double *a, double *b)
{
    factorise(n, a);
    for (int r = 0; r < rows; r++) {
        double *row = b + (size_t)r * (size_t)n;
        for (int i = 0; i < n; i++) {
            row[i] /= a[i * n + i];
            subtract(row[i], a + i * n, row, i + 1, n);
        }
        for (int i = n - 1; i > 0; i--) subtract(row[i], a + i * n, row, 0, i);
    }
}
