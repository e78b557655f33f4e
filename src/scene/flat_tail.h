/* What becomes of light that goes down through a level below which a scene is flat (P15):
 * a table, as adding-doubling makes it and engines read it. SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

/* Everything in it is owned. Zeroed: none. */
struct cml_flat_tail {
    int layer;  /* that has the level */
    double z;   /* of the level, below the layer's nominal top, cm */
    int scores; /* Tt, and A of layers layer + 1, layer + 2 ... */
    int intervals;
    double *index;   /* [intervals] that end the intervals of n sine, rising up to that of the layer */
    float *response; /* [intervals][CML_FLAT_TAIL_CELLS + 1][scores], shares in units of 2^-exponent, 0..1, at
                      * cosines in a medium of the interval's index whose roots are evenly spaced */
    int *exponent;   /* [scores] 0..CML_TAIL_MOST_EXPONENT */
};

#define CML_FLAT_TAIL_CELLS 1024 /* of an interval */
#define CML_TAIL_MOST_EXPONENT 54

/* What is less from every direction counts as 0: sums are of units of 2^-79, and each packet is rounded. */
#define CML_TAIL_LEAST 1e-20

/* Whether anything of a score is there. */
bool cml_flat_tail_has(const struct cml_flat_tail *tail, int score);

/* The widest root of a cosine in an interval. */
double cml_flat_tail_widest(const struct cml_flat_tail *tail, int interval);

void cml_flat_tail_clear(struct cml_flat_tail *tail);
