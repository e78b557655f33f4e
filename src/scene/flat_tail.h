/* The table behind rule P15: the expected fate of light that goes down through a level below which the scene
 * is flat. Adding-doubling fills the table, engines look values up in it.
 *
 *     shapes above            expected value (score, cosine) = table[interval][cell][score]
 *   ............. level z     a packet that crosses the level downwards adds weight * expected value
 *   ============= flat layers
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

/* A table of expected values by index interval, cosine and score. It owns all its arrays; zeroed, it is
 * empty. */
struct cml_flat_tail {
    int layer;  /* layer that contains the level, 1..L */
    double z;   /* depth of the level below the nominal top of its layer, cm */
    int scores; /* number of scores: Tt, then A of layers layer + 1, layer + 2 ... */
    int intervals;
    /* [intervals] Upper ends of the intervals of n sine, rising; the last one is the index of the level's
     * layer. */
    double *index;
    /* [intervals][CML_FLAT_TAIL_CELLS + 1][scores] Expected shares, 0..1, in units of 2^-exponent. Each row
     * stands for one cosine in a medium with the index of its interval; the square roots of these cosines are
     * evenly spaced. */
    float *response;
    int *exponent; /* [scores] binary exponent of each score's unit, 0..CML_TAIL_MOST_EXPONENT */
};

#define CML_FLAT_TAIL_CELLS 1024 /* cells of the cosine's root, per interval */
#define CML_TAIL_MOST_EXPONENT 54

/* Expected values below this limit count as 0. Sums are kept in units of 2^-79, and each packet's score is
 * rounded to them. */
#define CML_TAIL_LEAST 1e-20

/* True if light from any direction contributes to this score. */
bool cml_flat_tail_has(const struct cml_flat_tail *tail, int score);

/* Returns the largest square root of a cosine within an interval: table rows are spaced evenly up to it. */
double cml_flat_tail_widest(const struct cml_flat_tail *tail, int interval);

void cml_flat_tail_clear(struct cml_flat_tail *tail);
