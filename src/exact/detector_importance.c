/* SPDX-License-Identifier: MIT */
#include "exact/detector_importance.h"

#include "base/array.h"

#include <math.h>

enum { PIECES = 64 };

/* Finite volumes: rings about the middle of a detector, times pieces of layers. Unknown k belongs to ring k /
 * pieces and piece k % pieces. Both outer faces reflect light, which acts as if the way out were longer by 2
 * A. */
struct volumes {
    int rings, pieces;
    double *border; /* [rings + 1] radii of the borders of rings, cm */
    /* [pieces] thickness, depth of the middle, diffusion coefficient (cm), absorption (1/cm) */
    double *h, *middle, *D, *mua;
    double longer[2]; /* extra way 2 A of the upper and of the lower face (longer_by) */
    /* [unknowns][pieces + 1] the part of each row of the symmetric matrix up to its diagonal */
    double *band;
    double *value; /* [unknowns] right-hand side, then solution */
};

/* Returns 2 A of a face with relative index n, from Groenhuis' fit of its reflectance for diffuse light. */
static double longer_by(double n)
{
    const double R = fmax(0, -1.440 / (n * n) + 0.710 / n + 0.668 + 0.0636 * n);
    return 2 * (1 + R) / (1 - R);
}

/* Adds the pieces of a layer. Transport attenuation is at least `least`, because light in a clear layer would
 * diffuse without end. */
static void cut_layer(const struct cml_medium_def *medium, double top, double d, double depth, double least,
                      struct volumes *to)
{
    const double mutr = cml_medium_mutr(medium);
    const int n = 2 + (int)(PIECES * d / depth);
    for (int i = 0; i < n; i++, to->pieces++) {
        to->h[to->pieces] = d / n;
        to->middle[to->pieces] = top + (i + 0.5) * d / n;
        to->D[to->pieces] = 1 / (3 * fmax(mutr, least));
        to->mua[to->pieces] = medium->mua;
    }
}

/* Cuts the layers from the surface down to `depth`, cm, into pieces. Sets the borders of the rings between
 * the axis and the radius `reach`, cm; rings are narrower near the axis. */
static void cut(const struct cml_medium_def *media, int layers, double reach, double depth,
                struct volumes *to)
{
    double top = 0;
    int l = 0;
    while (l < layers && top < depth) {
        const double d = fmin(media[++l].d, depth - top);
        if (d > 0) cut_layer(&media[l], top, d, depth, 1 / reach, to);
        top += d;
    }
    to->longer[0] = longer_by(media[1].n / media[0].n);
    to->longer[1] = longer_by(media[l].n / media[l + 1].n);
    for (int i = 0; i <= to->rings; i++) to->border[i] = reach * pow((double)i / to->rings, 2);
}

/* Returns the area of a ring around the axis, cm2. */
static double area(const struct volumes *volumes, int ring)
{
    return M_PI * (pow(volumes->border[ring + 1], 2) - pow(volumes->border[ring], 2));
}

/* Returns the area of a ring that the detector sees, cm^2. */
static double seen_area(const struct volumes *volumes, int ring, struct cml_seen_rings seen)
{
    double sum = 0;
    for (int i = 0; i < seen.count; i++) {
        const double inner = fmax(seen.item[i].inner, volumes->border[ring]),
                     outer = fmin(seen.item[i].outer, volumes->border[ring + 1]);
        sum += outer > inner ? M_PI * (outer * outer - inner * inner) : 0;
    }
    return sum;
}

/* Returns the flow between a volume and the one below it in the same ring, per difference of their values. */
static double flow_down(const struct volumes *volumes, int ring, int piece)
{
    return area(volumes, ring) /
           (volumes->h[piece] / 2 / volumes->D[piece] + volumes->h[piece + 1] / 2 / volumes->D[piece + 1]);
}

/* Returns the flow between a volume and the next one outwards, per difference of their values. */
static double flow_out(const struct volumes *volumes, int ring, int piece)
{
    const double *border = volumes->border;
    return 4 * M_PI * border[ring + 1] * volumes->h[piece] * volumes->D[piece] /
           (border[ring + 2] - border[ring]);
}

/* Sets the matrix row of a volume, and its source: the flow into it from the detector. */
static void set_row(struct volumes *volumes, int ring, int piece, struct cml_seen_rings seen)
{
    const int n = volumes->pieces, k = ring * n + piece;
    double *row = volumes->band + (size_t)k * (size_t)(n + 1), *diagonal = row + n;
    *diagonal += area(volumes, ring) * volumes->h[piece] * volumes->mua[piece];
    for (int side = 0; side < 2; side++) {
        if (piece != (side ? n - 1 : 0)) continue;
        const double way = volumes->h[piece] / 2 / volumes->D[piece] + volumes->longer[side];
        *diagonal += area(volumes, ring) / way;
        if (side == seen.item->below) volumes->value[k] = seen_area(volumes, ring, seen) / way;
    }
    if (piece < n - 1) {
        const double flow = flow_down(volumes, ring, piece);
        *diagonal += flow;
        diagonal[n + 1] += flow;
        diagonal[n] = -flow;
    }
    if (ring < volumes->rings - 1) {
        const double flow = flow_out(volumes, ring, piece);
        *diagonal += flow;
        diagonal[(size_t)n * (size_t)(n + 1)] += flow;
        diagonal[(size_t)n * (size_t)(n + 1) - (size_t)n] = -flow;
    }
}

/* Returns the scalar product of two vectors of n numbers. */
static double dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

/* Solves the equations of the volumes by Cholesky's factors of the band matrix, which replace it. The matrix
 * is an M-matrix (negative off the diagonal), so no digits cancel. */
static void solve(struct volumes *volumes)
{
    const int n = volumes->pieces, all = volumes->rings * n;
    double *value = volumes->value;
#define AT(k, c) (volumes->band + (size_t)(k) * (size_t)(n + 1) + n - (k) + (c))
    for (int k = 0; k < all; k++) {
        const int first = k > n ? k - n : 0;
        for (int c = first; c <= k; c++) {
            const int from = c > n && c - n > first ? c - n : first;
            const double rest = *AT(k, c) - dot(AT(k, from), AT(c, from), c - from);
            *AT(k, c) = c < k ? rest / *AT(c, c) : sqrt(rest);
        }
        value[k] = (value[k] - dot(AT(k, first), value + first, k - first)) / *AT(k, k);
    }
    for (int k = all - 1; k >= 0; k--) {
        value[k] /= *AT(k, k);
        for (int c = k > n ? k - n : 0; c < k; c++) value[c] -= *AT(k, c) * value[k];
    }
#undef AT
}

/* Interpolates importance linearly in its logarithm between the middles of pieces; beyond the first and last
 * middle it is constant. */
static void interpolate(const struct volumes *volumes, double depth, int cells, double *to)
{
    const int n = volumes->pieces;
    const double *z = volumes->middle;
    for (int c = 0, i = 0; c < cells; c++) {
        const double at = (c + 0.5) / cells * depth;
        while (i < n - 2 && z[i + 1] < at) i++;
        const double part = fmin(1, fmax(0, (at - z[i]) / (z[i + 1] - z[i])));
        for (int r = 0; r < volumes->rings; r++) {
            const double *value = volumes->value + r * n + i;
            to[r * cells + c] = exp((1 - part) * log(value[0]) + part * log(value[1]));
        }
    }
}

static void *doubles(struct cml_arrays *arrays, size_t count)
{
    return cml_arrays_add(arrays, count, sizeof(double));
}

cml_status cml_importance_of_place(const struct cml_medium_def *media, int layers, struct cml_seen_rings seen,
                                   double reach, double depth, int rings, int cells, double *value,
                                   struct cml_error *err)
{
    const size_t most = PIECES + 2 * (size_t)layers, unknowns = (size_t)rings * most;
    CML_AT_END(cml_arrays_free) struct cml_arrays arrays = {0};
    struct volumes volumes = {.rings = rings,
                              .border = doubles(&arrays, (size_t)rings + 1),
                              .h = doubles(&arrays, most),
                              .middle = doubles(&arrays, most),
                              .D = doubles(&arrays, most),
                              .mua = doubles(&arrays, most),
                              .band = doubles(&arrays, unknowns * (most + 1)),
                              .value = doubles(&arrays, unknowns)};
    CML_TRY(cml_arrays_check(&arrays, "rings of layers", err));
    cut(media, layers, reach, depth, &volumes);
    for (int ring = 0; ring < rings; ring++)
        for (int piece = 0; piece < volumes.pieces; piece++) set_row(&volumes, ring, piece, seen);
    solve(&volumes);
    interpolate(&volumes, depth, cells, value);
    return CML_OK;
}
