/* SPDX-License-Identifier: MIT */
#include "exact/phase_moments.h"

#include "exact/directions.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Nodes and weights of a quadrature on (0, 1), kept for the next interval with as many nodes. */
struct rule {
    int nodes, most;
    double *node, *weight; /* [most] nodes and weights */
};

/* Sets up a Gauss-Legendre rule of this many nodes, unless the rule has them already. */
static void set_rule(struct rule *rule, int nodes)
{
    if (rule->nodes == nodes) return;
    rule->nodes = nodes;
    for (int i = 0; i < nodes; i++) {
        rule->node[i] = 0.5 + 0.5 * cml_gauss_node(nodes, i, &rule->weight[i]);
        rule->weight[i] /= 2;
    }
}

/* Adds share * g^l to each moment, also for negative g. */
static void add_power(double g, double share, int count, double *moment)
{
    for (int l = 0; l < count; l++) moment[l] += share * (g < 0 && l % 2 ? -1 : 1) * pow(fabs(g), l);
}

/* Returns the angle of a deflection 1 - cos(theta), rad, without loss of digits at small angles. */
static double angle_of(double deflection)
{
    return 2 * asin(fmin(sqrt(deflection / 2), 1));
}

/* Adds to the Legendre moments the integral between two deflections, where the density is smooth. The number
 * of nodes grows with `count`, because P_l has l / (2 pi) periods per radian. */
static void add_interval(const struct cml_phase *phase, double low, double high, int count, struct rule *rule,
                         double *moment)
{
    const int nodes = 12 + (int)ceil((angle_of(high) - angle_of(low)) * count / 3);
    set_rule(rule, nodes < rule->most ? nodes : rule->most);
    for (int i = 0; i < rule->nodes; i++) {
        const double x = low + (high - low) * rule->node[i], c = 1 - x;
        const double weight = rule->weight[i] * (high - low) * cml_phase_density(phase, x);
        double before = 0, p = 1;
        for (int l = 0; l < count; l++) {
            moment[l] += weight * p;
            const double next = ((2 * l + 1) * c * p - l * before) / (l + 1);
            before = p;
            p = next;
        }
    }
}

/* Integrates the Legendre moments of a phase function interval by interval. A table has an interval between
 * each two rows. Other functions have intervals from the preferred direction on, each twice as long as the
 * one before. */
static cml_status integrate(const struct cml_phase *phase, int count, double *moment, struct cml_error *err)
{
    const int most = 32 + 2 * count;
    CML_FREED double *node = calloc(2 * (size_t)most, sizeof *node);
    if (!node) return cml_fail_memory(err, 16.0 * most, "a phase function");
    struct rule rule = {.most = most, .node = node, .weight = node + most};
    if (phase->kind == CML_PHASE_TABLE) {
        for (int i = 1; i < phase->rows; i++)
            add_interval(phase, phase->deflection[i - 1], phase->deflection[i], count, &rule, moment);
    } else {
        const double g = phase->number[0];
        double low = 0, high = ldexp((1 - fabs(g)) * (1 - fabs(g)), -2);
        for (; low < 2; low = high, high = fmin(2 * high, 2))
            add_interval(phase, g < 0 ? 2 - high : low, g < 0 ? 2 - low : high, count, &rule, moment);
    }
    return CML_OK;
}

/* A share of cos^2 adds to moment 2; functions without a closed form are integrated. */
cml_status cml_phase_moments(const struct cml_medium_def *medium, int count, double *moment,
                             struct cml_error *err)
{
    const struct cml_phase *phase = medium->phase;
    const double *n = phase ? phase->number : NULL;
    memset(moment, 0, (size_t)count * sizeof *moment);
    if (!phase) {
        add_power(medium->g, 1, count, moment);
    } else if (phase->kind == CML_PHASE_HG2) {
        add_power(n[0], n[2], count, moment);
        add_power(n[1], 1 - n[2], count, moment);
    } else if (phase->kind == CML_PHASE_MHG) {
        add_power(n[0], n[1], count, moment);
        add_power(0, 1 - n[1], count, moment);
        if (count > 2) moment[2] += 0.4 * (1 - n[1]);
    } else if (phase->kind == CML_PHASE_RAYLEIGH) {
        add_power(0, 1, count, moment);
        if (count > 2) moment[2] += 0.1;
    } else {
        return integrate(phase, count, moment, err);
    }
    return CML_OK;
}
