/* Computes the response of a layer. Azimuthal means are enough for totals. With f+ and f- the power that goes
 * down and up in each direction, and S = f+ + f-, D = f+ - f-, the equation of transfer in a layer is
 *
 *     dS/dz = -P D,    P = (mua + mus - mus H_odd) / mu
 *     dD/dz = -Q S,    Q = (mua + mus - mus H_even) / mu
 *
 * where H_even and H_odd are the even and odd Legendre terms of the scattering function. If equal light comes
 * from both sides, S is even and D odd in z about the middle; if light of opposite signs comes, the reverse.
 * So R + T and R - T come from matrices of half the size, as power series in the thickness. Cut off after the
 * first term this would be the diamond initialisation (Wiscombe 1976); here the first layer is so thin that
 * the series are exact in double precision. It is then doubled [van de Hulst; Prahl, van Gemert, Welch 1993].
 * SPDX-License-Identifier: MIT */
#include "exact/layer_response.h"

#include "exact/dense.h"
#include "exact/phase_moments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* BUFFERS: number of n x n scratch matrices beside R and U. SERIES_TERMS: terms of the power series. */
enum { BUFFERS = 6, SERIES_TERMS = 9 };

/* The state of a layer's computation. */
struct work {
    int n, terms;
    struct cml_dense_kind kind;
    const struct cml_medium_def *medium;
    double *cosine, *weight; /* [n] cosine in this medium, and weight of integrals over the cosine */
    double *out;             /* [n] loss of each direction per length, 1/cm */
    double *buffer[BUFFERS]; /* [n + 1][n] scratch */
    double *scratch;         /* [n] scratch */
    double *moment;          /* [terms + 1] Legendre moments of the phase function */
};

/* Allocates the scratch arrays for the response of one layer; n is the number of directions. */
static void allocate_work(struct cml_arrays *arrays, struct work *w)
{
    const size_t n = (size_t)w->n;
    w->cosine = cml_arrays_add(arrays, n, sizeof(double));
    w->weight = cml_arrays_add(arrays, n, sizeof(double));
    w->out = cml_arrays_add(arrays, n, sizeof(double));
    w->scratch = cml_arrays_add(arrays, n, sizeof(double));
    w->moment = cml_arrays_add(arrays, (size_t)w->terms + 1, sizeof(double));
    for (int i = 0; i < BUFFERS; i++) w->buffer[i] = cml_arrays_add(arrays, n * (n + 1), sizeof(double));
}

/* Returns moment l of the truncated phase function times its share of mus and 2l + 1. The Legendre series is
 * cut off behind `terms` moments. The share |moment[terms]| is taken to go exactly forwards, which is no
 * scattering, or exactly backwards if g < 0 (delta-M, Wiscombe 1977). `terms` is even, so moment[terms] is
 * positive but for ripple. */
static double moment(const struct work *w, int l)
{
    const double rest = w->moment[w->terms];
    return (2 * l + 1) * (w->moment[l] - (w->medium->g < 0 && l % 2 == 1 ? -rest : rest));
}

/* Fills even and odd, [n][n], with the sums of mus (2l+1) moment_l P_l(mu_i) P_l(mu_j) over even and over odd
 * l. */
static void scattering(struct work *w, double *even, double *odd)
{
    const int n = w->n;
    double *before = w->buffer[2], *p = before + n; /* P_{l-1} and P_l at all cosines */
    memset(even, 0, (size_t)n * (size_t)n * sizeof *even);
    memset(odd, 0, (size_t)n * (size_t)n * sizeof *odd);
    for (int j = 0; j < n; j++) {
        before[j] = 0;
        p[j] = 1;
    }
    for (int l = 0; l < w->terms; l++) {
        const double factor = w->medium->mus * moment(w, l);
        double *sum = l % 2 == 0 ? even : odd;
        for (int i = 0; factor != 0 && i < n; i++)
            for (int j = 0; j < n; j++) sum[i * n + j] += factor * p[i] * p[j];
        for (int j = 0; j < n; j++) {
            const double next = ((2 * l + 1) * w->cosine[j] * p[j] - l * before[j]) / (l + 1);
            before[j] = p[j];
            p[j] = next;
        }
    }
}

/* Computes the matrices Q and P of the equation of transfer (head of this file). The scattering loss of a
 * direction is the sum that the quadrature finds in all directions. Energy is therefore conserved for any
 * order. Light scattered into its own direction counts as unscattered. Light scattered exactly backwards
 * leaves the sum S of both directions unchanged, and counts twice in their difference D. */
static void transfer(struct work *w, double *Q, double *P)
{
    const int n = w->n;
    const double back = w->medium->g < 0 ? w->medium->mus * w->moment[w->terms] : 0;
    scattering(w, Q, P);
    for (int j = 0; j < n; j++) {
        double scattered = 0;
        for (int i = 0; i < n; i++) scattered += w->weight[i] * Q[i * n + j];
        w->out[j] = w->medium->mua + scattered;
        for (int i = 0; i < n; i++) {
            Q[i * n + j] *= -w->weight[i] / w->cosine[j];
            P[i * n + j] *= -w->weight[i] / w->cosine[j];
        }
        Q[j * n + j] += w->out[j] / w->cosine[j];
        P[j * n + j] += (w->out[j] + 2 * back) / w->cosine[j];
        w->out[j] += 2 * back;
    }
}

/* Computes the matrix X = A s (c + A s)^-1 of half a thin layer, where c = cosh(h sqrt(K) / 2), s = sinh(h
 * sqrt(K) / 2) / sqrt(K) and K = B A are power series. row: [n], replaced by row s (c + A s)^-1; or NULL. X,
 * c, s, power: [n + 1][n]. */
static void half_response(struct work *w, double h, const double *A, const double *B, double *row, double *X)
{
    const int n = w->n;
    const size_t size = (size_t)n * (size_t)n;
    double *c = w->buffer[2], *s = w->buffer[3], *power = w->buffer[4], *next = w->buffer[5];
    memset(power, 0, size * sizeof *power);
    for (int i = 0; i < n; i++) power[i * n + i] = 1;
    memset(c, 0, size * sizeof *c);
    memset(s, 0, size * sizeof *s);
    double factor = 1;
    for (int l = 0; l < SERIES_TERMS; l++) {
        for (size_t i = 0; i < size; i++) {
            c[i] += factor * power[i];
            s[i] += factor * (h / 2) / (2 * l + 1) * power[i];
        }
        factor *= h * h / 4 / ((2 * l + 1) * (2 * l + 2));
        memset(next, 0, size * sizeof *next);
        cml_dense_add_product(&w->kind, 0, power, B, next);
        memset(power, 0, size * sizeof *power);
        cml_dense_add_product(&w->kind, 0, next, A, power);
    }
    memset(X, 0, (size + (size_t)n) * sizeof *X);
    cml_dense_add_product(&w->kind, 0, A, s, X);
    if (row) cml_dense_add_row_product(&w->kind, row, s, X + size);
    for (size_t i = 0; i < size; i++) c[i] += X[i];
    cml_dense_divide(&w->kind, row ? 1 : 0, c, X);
    if (row) memcpy(row, X + size, (size_t)n * sizeof *row);
}

/* Computes the response of a layer so thin (thickness h) that doubling can begin: R + T - 1 = -2 X(Q, P), R
 * - T + 1 = 2 X(P, Q). */
static void start(struct work *w, double h, struct cml_layer_response *to)
{
    const int n = w->n;
    double *Q = w->buffer[0], *P = w->buffer[1];
    for (int j = 0; j < n; j++) to->a[j] = 2 * w->medium->mua / w->cosine[j];
    half_response(w, h, Q, P, to->a, to->R);
    half_response(w, h, P, Q, NULL, to->U);
    for (size_t i = 0; i < (size_t)n * (size_t)n; i++) {
        const double even = to->R[i], odd = to->U[i];
        to->R[i] = odd - even;
        to->U[i] = -odd - even;
    }
}

/* Doubles a layer: computes the response of two equal layers, one upon the other. e is `through`, and X = (1
 * - R R)^-1 - 1. The light between the two is W = (1 + X) R T upwards and (1 + X) T = e + B downwards, where
 * B = U + e X + X U. T becomes e + e U + e B + U B, and R grows by T W. */
static void double_layer(struct work *w, struct cml_layer_response *to)
{
    const int n = w->n;
    const size_t size = (size_t)n * (size_t)n, bytes = size * sizeof(double);
    const double e = to->through;
    double *R = to->R, *U = to->U, *a = to->a;
    double *X = w->buffer[0], *B = w->buffer[1], *V = w->buffer[2], *W = w->buffer[3];
    memset(X, 0, bytes);
    cml_dense_add_product(&w->kind, 0, R, R, X);
    for (size_t i = 0; i < size; i++) B[i] = -X[i];
    for (int i = 0; i < n; i++) B[i * n + i] += 1;
    cml_dense_divide(&w->kind, 0, B, X);
    for (size_t i = 0; i < size; i++) B[i] = U[i] + e * X[i];
    cml_dense_add_product(&w->kind, 0, X, U, B);
    for (size_t i = 0; i < size; i++) V[i] = e * R[i];
    cml_dense_add_product(&w->kind, 0, R, U, V);
    memcpy(W, V, bytes);
    cml_dense_add_product(&w->kind, 0, X, V, W);
    for (int j = 0; j < n; j++) w->scratch[j] = (1 + e) * a[j];
    cml_dense_add_row_product(&w->kind, a, B, w->scratch);
    cml_dense_add_row_product(&w->kind, a, W, w->scratch);
    memcpy(a, w->scratch, (size_t)n * sizeof *a);
    for (size_t i = 0; i < size; i++) R[i] += e * W[i];
    cml_dense_add_product(&w->kind, 0, U, W, R);
    for (size_t i = 0; i < size; i++) X[i] = e * (U[i] + B[i]);
    cml_dense_add_product(&w->kind, 0, U, B, X);
    memcpy(U, X, bytes);
}

/* Returns the number of halvings after which thickness times loss rate is at most 1 in every direction. The
 * power series are then exact in double precision. */
static int halvings(double d, double rate)
{
    return (int)fmax(0, ceil(log2(d) + log2(rate)));
}

/* Returns the largest share of any direction's light that is transmitted into a single direction. */
static double most_through(const struct cml_layer_response *layer)
{
    const int n = layer->count;
    double most = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) most = fmax(most, fabs(layer->U[i * n + j] + (i == j) * layer->through));
    return most;
}

/* Moves `through` into U, so that U becomes the whole transmission T. */
static void count_all_through(struct cml_layer_response *layer)
{
    for (int j = 0; j < layer->count; j++) layer->U[j * layer->count + j] += layer->through;
    layer->through = 0;
}

/* Computes the response of a scattering layer. Doubling ends early when no light is transmitted any more,
 * because further thickness then changes nothing. */
static void fill_scattering(struct work *w, struct cml_layer_response *to)
{
    double rate = 0, most = 1;
    transfer(w, w->buffer[0], w->buffer[1]);
    for (int j = 0; j < w->n; j++) rate = fmax(rate, w->out[j] / w->cosine[j]);
    const int steps = halvings(w->medium->d, rate);
    start(w, ldexp(w->medium->d, -steps), to);
    for (int k = 0; k < steps && most > CML_LEAST_THROUGH; k++) {
        double_layer(w, to);
        most = most_through(to);
        if (most < 0.5) count_all_through(to);
    }
    if (most <= CML_LEAST_THROUGH) memset(to->U, 0, (size_t)w->n * (size_t)w->n * sizeof *to->U);
}

/* Computes the response of a layer without scattering, in which light keeps its direction. */
static void fill_absorbing(struct work *w, struct cml_layer_response *to)
{
    const int n = w->n;
    for (int j = 0; j < n; j++) {
        to->U[j * n + j] = exp(-w->medium->mua * w->medium->d / w->cosine[j]);
        to->a[j] = -expm1(-w->medium->mua * w->medium->d / w->cosine[j]);
    }
}

void cml_layer_response_clear(struct cml_layer_response *response)
{
    cml_arrays_free(&response->arrays);
    *response = (struct cml_layer_response){0};
}

/* Computes the cosine of each direction in this layer, and the weight of the direction in sums over angles.
 * Directions are fixed by index times sine, which all layers share. */
static void set_cosines(const struct cml_directions *directions, struct work *w)
{
    const double n = w->medium->n;
    for (int i = 0; i < w->n; i++) {
        w->cosine[i] = cml_directions_cosine(directions, i, n);
        w->weight[i] = directions->etendue[i] / (n * n * w->cosine[i]);
    }
}

cml_status cml_layer_response_create(const struct cml_medium_def *medium,
                                     const struct cml_directions *directions, int count, int terms,
                                     struct cml_layer_response *to, struct cml_error *err)
{
    struct work w = {
        .n = count, .terms = terms, .medium = medium, .kind = cml_directions_kind(directions, count)};
    CML_AT_END(cml_arrays_free) struct cml_arrays arrays = {0};
    const size_t n = (size_t)count;
    *to = (struct cml_layer_response){.count = count, .through = medium->mus > 0};
    to->R = cml_arrays_add(&to->arrays, n * (n + 1), sizeof(double));
    to->U = cml_arrays_add(&to->arrays, n * (n + 1), sizeof(double));
    to->a = cml_arrays_add(&to->arrays, n, sizeof(double));
    allocate_work(&arrays, &w);
    CML_TRY(cml_arrays_check(&to->arrays, "a layer", err));
    CML_TRY(cml_arrays_check(&arrays, "a layer", err));
    CML_TRY(cml_phase_moments(medium, terms + 1, w.moment, err));
    set_cosines(directions, &w);
    if (medium->mus > 0)
        fill_scattering(&w, to);
    else
        fill_absorbing(&w, to);
    return CML_OK;
}
