/* Random walks on the facets of a rough boundary (rule P20), and the discrete directions that they end in.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

/* The nodes between two neighbouring indices; their cosines refer to a medium of the upper index. */
struct cml_rough_interval {
    double index;         /* the upper index of the interval */
    int first, count;     /* number of the first direction, and of directions */
    const double *cosine; /* [count] cosines of the nodes, falling */
    const double *factor; /* [count] factors of the barycentric formula */
};

/* The start of walks on a rough boundary: its facets and media, the incident light, random numbers. */
struct cml_rough_start {
    int kind; /* enum cml_rough_kind */
    /* alpha: roughness. near, far: indices of the medium that light comes from, and of the medium beyond. */
    double alpha, near, far;
    /* The boundary is a backing: facets absorb the share `kept` and reflect the rest. */
    bool backed;
    double kept;
    double cosine;   /* cosine of the incident light */
    unsigned key[3]; /* key of the random numbers; different keys give independent walks */
    int part;        /* number of the part, 0..63; each part has random numbers of its own */
    int count;       /* number of walks in this part */
};

/* Makes `count` walks, each with the power 1 / count, and adds their power by direction to back[] and
 * beyond[]. Light that arrives between nodes is shared out to the nodes of its interval by the polynomials
 * through them. share: scratch for an interval. */
typedef void cml_rough_walker(const struct cml_rough_start *start, const struct cml_rough_interval *interval,
                              double *share, double *back, double *beyond);
