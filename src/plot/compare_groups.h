/* The statistics of a comparison (compare.h): bins of both results taken together until they hold enough
 * packets, and the test of such a group. SPDX-License-Identifier: MIT */
#pragma once

#include "result/outcome.h"

#define CML_COMPARE_PACKETS 20.0

enum { CML_COMPARE_BATCHES = 64 };

/* One test: a total (first = last = 0), a bin, or neighbouring bins. */
struct cml_compare_test {
    enum cml_quantity quantity;
    char key[CML_OUTCOME_KEY];    /* its name in files: of detectors each has its own */
    int first, last;              /* bins */
    double lower, upper;          /* their ends on the axis, cm, rad or ps; 0 of what has no such axis */
    int shape[CML_QUANTITY_AXES]; /* of an array of .h5 files; 0: of none, and behind its last axis */
    double value[2], error[2];    /* of both files in the file's unit; means over merged bins */
    double z, p;                  /* normal deviate, two-sided probability of it */
};

struct cml_comparison {
    int count; /* tests that are listed: all, but of arrays of .h5 files the worst of each */
    struct cml_compare_test
        *test; /* [count], owned, ordered by quantity, then by bin; arrays of .h5 files last */
    int tests; /* all */
    int tests_of[CML_NUM_QUANTITIES];
    int bins[CML_NUM_QUANTITIES]; /* in the tests of this quantity; 0: too few packets, or nothing to test */
    char left_out[512]; /* names, with commas, of arrays of both that have no errors or other bins */
    bool measured[2];   /* the file carries standard errors */
    bool lends[2];      /* they say how single packets scatter, to a file without any */
    int no_absorption;  /* A_z was left out; bit k: because run k did not tally it */
    double p;           /* Sidak-corrected: of a difference as large as the largest, by chance */
    int worst;          /* the test of the largest |z|, -1 when there is no test */
};

/* One quantity of both files, in weight per launched packet, or piece of it. */
struct cml_compare_quantity {
    enum cml_quantity which;
    char key[CML_OUTCOME_KEY];
    const struct cml_outcome *outcome[2];
    double packets[2];
    int bins;                     /* of all of it */
    int shape[CML_QUANTITY_AXES]; /* of what is shown by its indices; else 0 */
    int begin;                    /* number of the first bin that is here */
    const double *value[2];       /* as in the file */
    const double *error[2];       /* as in the file, NULL: none */
};

/* Neighbouring bins taken together. */
struct cml_compare_group {
    int first, last;
    double measure;               /* value times measure is weight per packet */
    double mean[2];               /* weight per packet */
    double squares[2], linear[2]; /* sums of the bins' errors */
    double rounding;              /* variance of the difference from printed digits */
};

/* How far a quantity has been read. Zeroed: not at all. */
struct cml_compare_scan {
    struct cml_compare_group open,
        closed; /* bins since the last group, and that group, which is not tested yet */
    int tests;
};

/* Whether a packet of the file is independent of the others, so that errors say how packets scatter: not
 * where they were spread evenly (--sampling lattice), which errors gain from. */
bool cml_compare_lends(const struct cml_outcome *outcome);

/* Goes on with bins q->begin to end - 1; then with what is left over. An array of files keeps its worst test.
 */
void cml_compare_scan_bins(const struct cml_compare_quantity *q, int end, struct cml_compare_scan *scan,
                           struct cml_comparison *c);
void cml_compare_end_scan(const struct cml_compare_quantity *q, struct cml_compare_scan *scan,
                          struct cml_comparison *c);

/* A bin by itself, which is here. */
void cml_compare_one_bin(const struct cml_compare_quantity *q, int i, struct cml_compare_scan *scan,
                         struct cml_comparison *c);

static inline bool cml_compare_comes_of(enum cml_quantity which, enum cml_estimator estimator)
{
    return cml_quantities[which].estimator == estimator;
}

/* Only .h5 files hold it, never an outcome. */
static inline bool cml_compare_is_of_files(enum cml_quantity which)
{
    return cml_compare_comes_of(which, CML_FROM_FIELD);
}
