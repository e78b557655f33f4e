/* SPDX-License-Identifier: MIT */
#include "scene/phase.h"

#include "base/array.h"
#include "base/shared.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

const char *cml_phase_name(enum cml_phase_kind kind)
{
    static const char *const names[CML_PHASE_KINDS] = {"hg2", "mhg", "gk", "rayleigh", "table"};
    return names[kind];
}

/* ---- tables ---- */

bool cml_phase_scale_table(struct cml_phase *phase)
{
    const size_t bytes = (size_t)phase->rows * sizeof(double);
    const double *x = phase->deflection;
    double *p = phase->density, *below = phase->below, all = 0;
    for (int i = 1; i < phase->rows; i++) {
        below[i - 1] = all;
        all += (x[i] - x[i - 1]) * (p[i] + p[i - 1]) / 2;
    }
    if (!(all > 0) || !isfinite(all)) return false;
    below[phase->rows - 1] = all;
    for (int i = 0; i < phase->rows; i++) {
        p[i] /= all;
        below[i] /= all;
    }
    const uLong sum = crc32_z(0, (const Bytef *)x, bytes);
    phase->checksum = (uint32_t)crc32_z(sum, (const Bytef *)p, bytes);
    return true;
}

/* Returns the row i, 0..rows - 2, whose interval to row i + 1 contains the deflection. */
static int row_of(const struct cml_phase *phase, double deflection)
{
    return (int)cml_last_not_above(phase->deflection, (size_t)phase->rows - 1, deflection);
}

/* Returns the density of a tabulated phase function at a deflection 1 - cos(theta), interpolated between
 * rows. */
static double table_density(const struct cml_phase *phase, double deflection)
{
    const int i = row_of(phase, deflection);
    const double *x = phase->deflection + i, *p = phase->density + i;
    return p[0] + (p[1] - p[0]) * (deflection - x[0]) / (x[1] - x[0]);
}

/* Returns the probability that light of a tabulated phase function is deflected by less than `deflection`:
 * the sum up to the row before, and a trapezium from there. */
static double table_below(const struct cml_phase *phase, double deflection)
{
    const int i = row_of(phase, deflection);
    const double p = table_density(phase, deflection);
    return phase->below[i] + (deflection - phase->deflection[i]) * (phase->density[i] + p) / 2;
}

/* Returns the mean cosine g of a tabulated phase function. The table has the density over the deflection 1 -
 * cos(theta). Between rows the density is linear, and each summand is the exact integral of deflection times
 * density. */
static double table_mean(const struct cml_phase *phase)
{
    double sum = 0;
    for (int i = 1; i < phase->rows; i++) {
        const double a = phase->deflection[i - 1], b = phase->deflection[i];
        sum += (b - a) * (phase->density[i - 1] * (2 * a + b) + phase->density[i] * (a + 2 * b)) / 6;
    }
    return 1 - sum;
}

/* ---- closed forms ---- */

/* Returns the share of light that Henyey and Greenstein's function scatters below the deflection x = 1 -
 * cosine. With a = 1 - g and b = sqrt(a^2 + 2 g x) the share is (1 - g^2) / (2 g) (1 / a - 1 / b). The code
 * avoids this difference, in which digits cancel for small g or x. */
static double hg_below(double g, double x)
{
    const double a = 1 - g, b = sqrt(a * a + 2 * g * x);
    return (1 - g * g) * x / (a * b * (a + b));
}

/* Returns the density of Henyey and Greenstein's phase function at the deflection x = 1 - cos(theta). */
static double hg_density(double g, double x)
{
    return (1 - g * g) / 2 / pow((1 - g) * (1 - g) + 2 * g * x, 1.5);
}

/* Returns the logarithm of (1 + g^2 - 2 g c) / (1 - g)^2 for the deflection x = 1 - c. */
static double gk_log(double g, double x)
{
    return log1p(2 * g * x / ((1 - g) * (1 - g)));
}

/* Returns the share of gk below the deflection x; its limits at g = 0 and at a = 0. */
static double gk_below(double g, double a, double x)
{
    if (g == 0) return x / 2;
    if (a == 0) return gk_log(g, x) / gk_log(g, 2);
    return expm1(-a * gk_log(g, x)) / expm1(-a * gk_log(g, 2));
}

/* Returns a / (1 - exp(-a L)), the factor that normalises the density of the phase function gk. L = `all`. At
 * a = 0 returns the limit 1 / L. */
static double gk_scale(double a, double all)
{
    return a == 0 ? 1 / all : -a / expm1(-a * all);
}

/* Returns the density of the Gegenbauer kernel phase function at the deflection x = 1 - cos(theta). */
static double gk_density(double g, double a, double x)
{
    if (g == 0) return 0.5;
    return gk_scale(a, gk_log(g, 2)) * exp(-a * gk_log(g, x)) * 2 * g / ((1 - g) * (1 - g) + 2 * g * x);
}

/* Returns the mean cosine of gk by Simpson's rule over t = log / all. In t the deflection is (1 - g)^2
 * expm1(t all) / (2 g), and its density is gk_scale all exp(-a t all): both are smooth. */
static double gk_mean(double g, double a)
{
    enum { STEPS = 2000 };
    const double all = gk_log(g, 2);
    double sum = 0;
    if (g == 0) return 0;
    for (int i = 0; i <= STEPS; i++) {
        const double log = all * i / STEPS, x = (1 - g) * (1 - g) * expm1(log) / (2 * g);
        sum += (i == 0 || i == STEPS ? 1 : i % 2 == 1 ? 4 : 2) * x * exp(-a * log);
    }
    return 1 - gk_scale(a, all) * all * sum / (3 * STEPS);
}

double cml_phase_below(const struct cml_phase *phase, double x)
{
    const double *n = phase->number;
    switch (phase->kind) {
    case CML_PHASE_HG2:
        return n[2] * hg_below(n[0], x) + (1 - n[2]) * hg_below(n[1], x);
    case CML_PHASE_MHG:
        return n[1] * hg_below(n[0], x) + (1 - n[1]) * x * (3 - 3 * x + x * x) / 2;
    case CML_PHASE_GK:
        return gk_below(n[0], n[1], x);
    case CML_PHASE_RAYLEIGH:
        return x * (6 - 3 * x + x * x) / 8;
    default:
        return table_below(phase, x);
    }
}

double cml_phase_density(const struct cml_phase *phase, double x)
{
    const double *n = phase->number, c = 1 - x;
    switch (phase->kind) {
    case CML_PHASE_HG2:
        return n[2] * hg_density(n[0], x) + (1 - n[2]) * hg_density(n[1], x);
    case CML_PHASE_MHG:
        return n[1] * hg_density(n[0], x) + (1 - n[1]) * 1.5 * c * c;
    case CML_PHASE_GK:
        return gk_density(n[0], n[1], x);
    case CML_PHASE_RAYLEIGH:
        return 0.375 * (1 + c * c);
    default:
        return table_density(phase, x);
    }
}

double cml_phase_mean(const struct cml_phase *phase)
{
    const double *n = phase->number;
    switch (phase->kind) {
    case CML_PHASE_HG2:
        return n[2] * n[0] + (1 - n[2]) * n[1];
    case CML_PHASE_MHG:
        return n[1] * n[0];
    case CML_PHASE_GK:
        return gk_mean(n[0], n[1]);
    case CML_PHASE_RAYLEIGH:
        return 0;
    default:
        return table_mean(phase);
    }
}

/* ---- words and lists ---- */

bool cml_phase_equal(const struct cml_phase *a, const struct cml_phase *b)
{
    const size_t bytes = (size_t)a->rows * sizeof(double);
    if (a->kind != b->kind || a->rows != b->rows || a->checksum != b->checksum) return false;
    if (memcmp(a->number, b->number, sizeof a->number) != 0) return false;
    return bytes == 0 ||
           (memcmp(a->deflection, b->deflection, bytes) == 0 && memcmp(a->density, b->density, bytes) == 0);
}

void cml_phase_print(FILE *stream, const struct cml_phase *phase, bool sums)
{
    static const int numbers[CML_PHASE_KINDS] = {
        [CML_PHASE_HG2] = 3, [CML_PHASE_MHG] = 2, [CML_PHASE_GK] = 2};
    fputs(cml_phase_name(phase->kind), stream);
    for (int i = 0; i < numbers[phase->kind]; i++) fprintf(stream, " %.9g", phase->number[i]);
    if (phase->kind != CML_PHASE_TABLE) return;
    fprintf(stream, " of %d rows", phase->rows);
    if (sums) fprintf(stream, ", crc32 %08x", phase->checksum);
}

/* Frees a phase function. The rows of a table may belong to several scenes, and go with the last one. */
static void phase_free(struct cml_phase *phase)
{
    if (cml_share_end(phase->users)) {
        free(phase->deflection);
        free(phase->density);
        free(phase->below);
        free(phase->file);
    }
    free(phase);
}

void cml_phases_free(struct cml_phase *first)
{
    while (first) {
        struct cml_phase *next = first->next;
        phase_free(first);
        first = next;
    }
}
