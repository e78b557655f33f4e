/* Walks on the facets of a rough boundary (P20), and the discrete directions that they
 * lead to. SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

/* The nodes between two neighbouring indices, in a medium of the upper one. */
struct cml_rough_interval {
    double index;         /* the upper one; that of a medium on one side lies above all directions there */
    int first, count;     /* directions */
    const double *cosine; /* [count] falling */
    const double *factor; /* [count] of the barycentric formula */
};

struct cml_rough_start {
    int kind;                /* enum cml_rough_kind */
    double alpha, near, far; /* indices of the medium that light comes from, and beyond */
    bool backed;             /* facets reflect what they do not keep, and nothing passes */
    double kept;
    double cosine;   /* of light that comes */
    unsigned key[3]; /* of random numbers: another one is independent */
    int part;        /* of the walks, 0..63; each has random numbers of its own */
    int count;       /* walks of this part */
};

/* Adds `count` walks, each with the power 1 / count, to the power back[] and beyond[] by direction. Light
 * that arrives between nodes is shared out to the nodes of its interval by the polynomials through them.
 * share: scratch for an interval. */
typedef void cml_rough_walker(const struct cml_rough_start *start, const struct cml_rough_interval *interval,
                              double *share, double *back, double *beyond);
