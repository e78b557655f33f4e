/* Azimuthal means are enough for totals. With f+ and f- the power that goes down and up in each direction,
 * and S = f+ + f-, D = f+ - f-, the equation of transfer in a layer is
 *
 *     dS/dz = -P D,    P = (mua + mus - mus H_odd) / mu
 *     dD/dz = -Q S,    Q = (mua + mus - mus H_even) / mu
 *
 * where H_even and H_odd are the even and odd Legendre terms of the scattering function. Light that comes
 * alike from both sides has S even and D odd in z about the middle, light that comes with opposite signs the
 * reverse. So R + T and R - T come from matrices of half the size, as power series in the thickness. Cut off
 * behind the first term they would be the diamond initialisation (Wiscombe 1976); here the layer is so thin
 * that they are exact in double precision. It is then doubled [van de Hulst; Prahl, van Gemert, Welch 1993].
 * SPDX-License-Identifier: MIT */
#include "exact/layer_response.h"

#include "exact/dense.h"
#include "exact/phase_moments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Matrices of n x n that are needed beside R and U. */
enum { BUFFERS = 6, SERIES_TERMS = 9 };

/* A layer while it is being made. */
struct work {
    int n, terms;
    struct cml_dense_kind kind;
    const struct cml_medium_def *medium;
    double *cosine, *weight; /* [n] in this medium: the weights of integrals over the cosine */
    double *out;             /* [n] what a direction loses per cm, 1/cm */
    double *buffer[BUFFERS]; /* [n + 1][n] */
    double *scratch;         /* [n] */
    double *moment;          /* [terms + 1] Legendre moments of the phase function */
};

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

/* The phase function's Legendre series is cut off behind `terms` moments: the share |moment[terms]| is taken
 * to go exactly on, which is no scattering, or exactly back where g < 0 (delta-M, Wiscombe 1977). Moment l of
 * what is left, times its share of mus, times 2l + 1. `terms` is even, so the moment has no sign there but
 * that of a ripple. */
static double moment(const struct work *w, int l)
{
    const double rest = w->moment[w->terms];
    return (2 * l + 1) * (w->moment[l] - (w->medium->g < 0 && l % 2 == 1 ? -rest : rest));
}

/* even, odd: [n][n] sums of mus (2l+1) moment_l P_l(mu_i) P_l(mu_j) over even and odd l. */
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

/* What a direction loses by scattering is what the quadrature finds in all others, so energy is conserved for
 * any order; to keep light in its direction is no scattering. Light that goes exactly back is lost to S
 * nowhere, to D twice. */
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

/* X = A s (c + A s)^-1, with c = cosh(h sqrt(K) / 2), s = sinh(h sqrt(K) / 2) / sqrt(K), K = B A, as power
 * series. row, or NULL: [n], becomes row s (c + A s)^-1. X, c, s, power: [n + 1][n]. */
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

/* A layer of thickness h. R + T - 1 = -2 X(Q, P), R - T + 1 = 2 X(P, Q). */
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

/* Two of the same, one upon the other; e: `through`. With X = (1 - RR)^-1 - 1, W = (1 + X) R T goes up
 * between them and (1 + X) T = e + B down, B = U + eX + X U; T grows to e + eU + eB + U B, R by T W. */
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

/* Halvings after which no direction loses more than d rate = 1 over a layer: there the series are exact. */
static int halvings(double d, double rate)
{
    return (int)fmax(0, ceil(log2(d) + log2(rate)));
}

/* The largest part of a direction's light that goes through into one direction. */
static double most_through(const struct cml_layer_response *layer)
{
    const int n = layer->count;
    double most = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) most = fmax(most, fabs(layer->U[i * n + j] + (i == j) * layer->through));
    return most;
}

/* Counts what goes straight through with the rest: U becomes T. */
static void count_all_through(struct cml_layer_response *layer)
{
    for (int j = 0; j < layer->count; j++) layer->U[j * layer->count + j] += layer->through;
    layer->through = 0;
}

/* Doubling ends where nothing comes through any more: then more of the same changes nothing. */
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

/* Fills the response of a layer without scattering, where no light changes its direction. */
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
    struct cml_arrays arrays = {0};
    const size_t n = (size_t)count;
    *to = (struct cml_layer_response){.count = count, .through = medium->mus > 0};
    to->R = cml_arrays_add(&to->arrays, n * (n + 1), sizeof(double));
    to->U = cml_arrays_add(&to->arrays, n * (n + 1), sizeof(double));
    to->a = cml_arrays_add(&to->arrays, n, sizeof(double));
    allocate_work(&arrays, &w);
    cml_status status = cml_arrays_check(&to->arrays, "a layer", err);
    if (status == CML_OK) status = cml_arrays_check(&arrays, "a layer", err);
    if (status == CML_OK) status = cml_phase_moments(medium, terms + 1, w.moment, err);
    if (status == CML_OK) {
        set_cosines(directions, &w);
        if (medium->mus > 0)
            fill_scattering(&w, to);
        else
            fill_absorbing(&w, to);
    } else {
        cml_layer_response_clear(to);
    }
    cml_arrays_free(&arrays);
    return status;
}
