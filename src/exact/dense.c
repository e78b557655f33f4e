/* SPDX-License-Identifier: MIT */
#include "exact/dense.h"

#include <stdbool.h>
#include <stddef.h>

static double *row_of(double *matrix, int n, int i)
{
    return matrix + (size_t)i * (size_t)n;
}

/* True if row i of a matrix is full: it may have other elements than its diagonal. Calls must come with
 * rising i; *next counts the full rows met until now, from 0. */
static bool is_full(const struct cml_dense_kind *kind, int i, int *next)
{
    const bool full = *next < kind->num_full && kind->full[*next] == i;
    *next += full;
    return full;
}

/* Adds four rows of b at once, so that c is read and written a quarter as often. */
void cml_dense_add_row_product(const struct cml_dense_kind *kind, const double *restrict a,
                               const double *restrict b, double *restrict c)
{
    const int n = kind->n, *full = kind->full;
    int f = 0, met = 0;
    for (; f + 4 <= kind->num_full; f += 4) {
        const double *b0 = b + (size_t)full[f] * (size_t)n, *b1 = b + (size_t)full[f + 1] * (size_t)n,
                     *b2 = b + (size_t)full[f + 2] * (size_t)n, *b3 = b + (size_t)full[f + 3] * (size_t)n;
        const double a0 = a[full[f]], a1 = a[full[f + 1]], a2 = a[full[f + 2]], a3 = a[full[f + 3]];
        for (int j = 0; j < n; j++) c[j] += (a0 * b0[j] + a1 * b1[j]) + (a2 * b2[j] + a3 * b3[j]);
    }
    for (; f < kind->num_full; f++)
        for (int j = 0; j < n; j++) c[j] += a[full[f]] * b[(size_t)full[f] * (size_t)n + (size_t)j];
    for (int k = 0; k < n; k++)
        if (!is_full(kind, k, &met)) c[k] += a[k] * b[(size_t)k * (size_t)n + (size_t)k];
}

void cml_dense_add_product(const struct cml_dense_kind *kind, int more, const double *a, const double *b,
                           double *c)
{
    const int n = kind->n;
    for (int i = 0, met = 0; i < n + more; i++) {
        const size_t row = (size_t)i * (size_t)n, diagonal = row + (size_t)i;
        if (i >= n || is_full(kind, i, &met))
            cml_dense_add_row_product(kind, a + row, b, c + row);
        else
            c[diagonal] += a[diagonal] * b[diagonal];
    }
}

void cml_dense_add_general(int rows, int middle, int columns, const double *restrict a,
                           const double *restrict b, double *restrict c)
{
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < middle; k++) {
            const double factor = a[(size_t)i * (size_t)middle + (size_t)k];
            const double *from = b + (size_t)k * (size_t)columns;
            for (int j = 0; j < columns; j++) c[(size_t)i * (size_t)columns + (size_t)j] += factor * from[j];
        }
}

/* Subtracts a multiple of one row from another: to[j] -= factor from[j] for first <= j < end. */
static void subtract(double factor, const double *restrict from, double *restrict to, int first, int end)
{
    for (int j = first; j < end; j++) to[j] -= factor * from[j];
}

/* Replaces a by its factors: L below the diagonal, whose own diagonal is 1, and U. */
static void factorise(const struct cml_dense_kind *kind, double *a)
{
    const int n = kind->n;
    for (int k = 0, met = 0; k < n; k++) {
        const bool full = is_full(kind, k, &met);
        const double *from = row_of(a, n, k);
        for (int f = met; f < kind->num_full; f++) {
            double *to = row_of(a, n, kind->full[f]);
            to[k] /= from[k];
            if (full) subtract(to[k], from, to, k + 1, n);
        }
    }
}

/* A row of b that is not full has only its diagonal element, so it is divided by that of a. */
void cml_dense_divide(const struct cml_dense_kind *kind, int more, double *a, double *b)
{
    const int n = kind->n;
    factorise(kind, a);
    for (int r = 0, met = 0; r < n + more; r++) {
        double *row = row_of(b, n, r);
        if (r < n && !is_full(kind, r, &met)) {
            row[r] /= row_of(a, n, r)[r];
            continue;
        }
        for (int i = 0, full = 0; i < n; i++) {
            row[i] /= row_of(a, n, i)[i];
            if (is_full(kind, i, &full)) subtract(row[i], row_of(a, n, i), row, i + 1, n);
        }
        for (int f = kind->num_full - 1; f >= 0; f--)
            subtract(row[kind->full[f]], row_of(a, n, kind->full[f]), row, 0, kind->full[f]);
    }
}
