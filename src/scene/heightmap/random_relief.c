/* SPDX-License-Identifier: MIT */
#include "scene/heightmap/random_relief.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>

static const double tau = 6.283185307179586; /* 2 pi */

/* ---- noise ---- */

/* Returns the next random word of SplitMix64 [Steele, Lea, Flood, Fast splittable pseudorandom number
 * generators, OOPSLA 2014]. */
static uint64_t next_word(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* Returns a random number strictly between 0 and 1. */
static double uniform(uint64_t *state)
{
    return ((double)(next_word(state) >> 12) + 0.5) * 0x1p-52;
}

/* Returns two independent normal deviates as one complex number (Box and Muller). */
static double complex normal_pair(uint64_t *state)
{
    const double radius = sqrt(-2 * log(uniform(state))), angle = tau * uniform(state);
    return radius * cos(angle) + radius * sin(angle) * I;
}

/* ---- Fourier transform ---- */

/* Moves every element i to the index with i's bits in reverse order, as the fast Fourier transform needs. */
static void reverse_bits(double complex *x, int n)
{
    for (int i = 1, j = 0; i < n; i++) {
        int bit = n / 2;
        for (; j & bit; bit /= 2) j ^= bit;
        j ^= bit;
        if (i >= j) continue;
        const double complex kept = x[i];
        x[i] = x[j];
        x[j] = kept;
    }
}

/* Replaces x[k] by the sum over i of x[i] exp(2 pi i k / n sqrt(-1)), for n a power of two. root[m] is exp(2
 * pi m / n sqrt(-1)) for m < n / 2. [Cooley, Tukey, Math. Comput. 19, 297 (1965)] */
static void transform(double complex *x, const double complex *root, int n)
{
    reverse_bits(x, n);
    for (int half = 1; half < n; half *= 2)
        for (int first = 0; first < n; first += 2 * half)
            for (int k = 0; k < half; k++) {
                double complex *low = &x[first + k], *high = low + half;
                const double complex turned = *high * root[k * (n / (2 * half))];
                *high = *low - turned;
                *low += turned;
            }
}

/* Swaps rows and columns of x[n][n]. */
static void transpose(double complex *x, size_t n)
{
    for (size_t j = 0; j < n; j++)
        for (size_t i = 0; i < j; i++) {
            const double complex kept = x[j * n + i];
            x[j * n + i] = x[i * n + j];
            x[i * n + j] = kept;
        }
}

/* Does the two-dimensional Fourier transform of x[n][n]. The result has rows and columns swapped. */
static void transform_plane(double complex *x, const double complex *root, int n)
{
    for (int axis = 0; axis < 2; axis++) {
        for (int j = 0; j < n; j++) transform(x + (size_t)j * (size_t)n, root, n);
        if (axis == 0) transpose(x, (size_t)n);
    }
}

/* ---- spectrum ---- */

/* Returns the square root of the power at the wave numbers i, j of the period. Numbers beyond n / 2 stand for
 * negative ones. */
static double amplitude(const struct cml_random_relief *relief, int i, int j)
{
    const int n = relief->points, m = i > n / 2 ? i - n : i, k = j > n / 2 ? j - n : j;
    const double step = tau * CML_RELIEF_STEPS / n, /* step of k L from one wave number to the next */
        square = step * step * ((double)m * m + (double)k * k);
    return relief->hurst > 0 ? pow(1 + square, -(1 + relief->hurst) / 2) : exp(-square / 8);
}

/* Filters the noise in x[n][n]. Its real and imaginary parts become independent reliefs, of which the caller
 * takes the real one. The spectrum is the same along both axes, so swapped rows and columns do not matter. */
static void filter_noise(const struct cml_random_relief *relief, double complex *x,
                         const double complex *root)
{
    const int n = relief->points;
    uint64_t state = relief->seed;
    for (size_t i = 0; i < (size_t)n * (size_t)n; i++) x[i] = normal_pair(&state);
    transform_plane(x, root, n);
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) x[(size_t)j * (size_t)n + (size_t)i] *= amplitude(relief, i, j);
    transform_plane(x, root, n);
}

/* ---- heights ---- */

/* Returns the rms gradient of the facets. One facet of each cell contains the cell's lower edge along x, the
 * other facet the upper edge, and likewise along y. The mean square of the gradients is therefore the mean
 * over all edges. */
static double rms_gradient(const struct cml_heightmap *tile)
{
    double sum = 0;
    for (int64_t j = 0; j < tile->ny; j++)
        for (int64_t i = 0; i < tile->nx; i++) {
            const double h = cml_tile_height(tile, i, j);
            const double along_x = (cml_tile_height(tile, i + 1, j) - h) / tile->dx,
                         along_y = (cml_tile_height(tile, i, j + 1) - h) / tile->dy;
            sum += along_x * along_x + along_y * along_y;
        }
    return sqrt(sum / ((double)tile->nx * (double)tile->ny));
}

/* Scales the heights to the requested slope, then moves the mean of the facets to 0, which holds but for
 * rounding. */
static void scale_heights(const struct cml_random_relief *relief, struct cml_heightmap *map)
{
    const size_t count = (size_t)map->nx * (size_t)map->ny;
    const double factor = relief->slope / rms_gradient(map);
    for (size_t i = 0; i < count; i++) map->h[i] *= factor;
    const double mean = cml_tile_mean(map);
    for (size_t i = 0; i < count; i++) map->h[i] -= mean;
}

cml_status cml_random_relief_make(const struct cml_random_relief *relief, struct cml_heightmap *map,
                                  struct cml_error *err)
{
    const int n = relief->points;
    const size_t count = (size_t)n * (size_t)n;
    CML_TRY(cml_heightmap_allocate("the relief", n, n, map, err));
    CML_FREED double complex *x = malloc(count * sizeof *x), *root = malloc((size_t)n / 2 * sizeof *root);
    if (!x || !root) {
        cml_heightmap_clear(map);
        return cml_fail_memory(err, (double)(count * sizeof *x), "a relief");
    }
    for (int m = 0; m < n / 2; m++) root[m] = cos(tau * m / n) + sin(tau * m / n) * I;
    filter_noise(relief, x, root);
    for (size_t i = 0; i < count; i++) map->h[i] = creal(x[i]);
    map->dx = map->dy = relief->length / CML_RELIEF_STEPS;
    cml_heightmap_centre(map);
    scale_heights(relief, map);
    return CML_OK;
}

/* ---- what was drawn ---- */

/* Returns the mean of the products h(x, y) h(x + lag, y) and h(x, y) h(x, y + lag), with heights counted from
 * the mean. */
static double correlation(const struct cml_heightmap *tile, double mean, int64_t lag)
{
    double sum = 0;
    for (int64_t j = 0; j < tile->ny; j++)
        for (int64_t i = 0; i < tile->nx; i++)
            sum += (cml_tile_height(tile, i, j) - mean) *
                   (cml_tile_height(tile, i + lag, j) + cml_tile_height(tile, i, j + lag) - 2 * mean);
    return sum / 2 / ((double)tile->nx * (double)tile->ny);
}

void cml_random_relief_measure(const struct cml_heightmap *tile, struct cml_drawn_relief *drawn)
{
    struct cml_relief relief;
    cml_heightmap_measure(tile, tile->h, &relief);
    *drawn = (struct cml_drawn_relief){.rms = relief.rms, .slope = rms_gradient(tile)};
    const double variance = relief.rms * relief.rms, e = exp(1);
    double before = 1;
    for (int lag = 1; lag <= tile->nx / 2 && drawn->length == 0; lag++) {
        const double now = correlation(tile, relief.mean, lag) / variance;
        if (now < 1 / e) drawn->length = tile->dx * (lag - (1 / e - now) / (before - now));
        before = now;
    }
}
