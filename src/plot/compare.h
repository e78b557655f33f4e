/* Do two results agree within their noise? Totals and profiles of two .mco files, bin by bin.
 *
 * Every number is turned into weight per launched packet; z = (a - b) / error of the difference.
 * Errors: our files carry standard errors. A file without any (original MCML) takes the mean square over the
 * mean of a packet's score from the other file, from a range of bins with enough packets, and with it has
 * the variance of its mean; where neither has errors, or the other has drawn from a lattice (and keeps its
 * own errors), that ratio is 1, its largest value for scores x <= 1, so that real differences may be missed
 * but none is invented. Rsp of a file without errors is exact, as every MCML computes it. When both have
 * errors the larger of two estimates counts: the sum of both variances, and the one of a variance common to
 * both, which a run of few packets cannot understate by luck. The digits that a file prints count as a
 * rounding error. Few packets: neighbouring bins are taken together until the smaller run has
 * CML_COMPARE_PACKETS packets of the mean weight in them; what is left over at a profile's end joins its last
 * group. The errors of reflected and transmitted bins add in squares (a packet ends in one bin), those of
 * absorbed bins linearly, and at most to the bound above (a packet deposits in many). All errors come from 64
 * batches and make z a Student deviate, which is turned into the normal one of the same tail. Sidak's
 * correction over all tests is exact for independent bins and conservative for correlated ones
 * (significance.h), which bins and their totals are. Two runs of one seed share their noise: they always
 * agree. Not compared: A_l (MCML forms it from z bins), the grids over (r, z) and (r, angle), which have no
 * errors; A_z where one run did not tally absorption; what only one run has by time. SPDX-License-Identifier:
 * MIT */
#ifndef CML_COMPARE_H
#define CML_COMPARE_H

#include "result/outcome.h"

#define CML_COMPARE_PACKETS 20.0

/* Whether a quantity is compared: totals and profiles are. */
bool cml_compare_tests(enum cml_quantity quantity);

/* One test: a total (first = last = 0), a bin, or neighbouring bins. */
struct cml_compare_test {
    enum cml_quantity quantity;
    char key[CML_OUTCOME_KEY]; /* its name in files: of detectors each has its own */
    int first, last;           /* bins */
    double lower, upper;       /* their ends on the axis, cm, rad or ps */
    double value[2], error[2]; /* of both files in the file's unit; means over merged bins */
    double z, p;               /* normal deviate, two-sided probability of it */
};

struct cml_comparison {
    int count;                     /* tests */
    struct cml_compare_test *test; /* [count], owned, ordered by quantity, then by bin */
    int bins[CML_NUM_QUANTITIES];  /* in the tests of this quantity; 0: too few packets, or nothing to test */
    bool measured[2];              /* the file carries standard errors */
    bool lends[2];                 /* they say how single packets scatter, to a file without any */
    bool no_absorption;            /* A_z was left out, because one run did not tally it */
    double p;                      /* Sidak-corrected: of a difference as large as the largest, by chance */
    int worst;                     /* the test of the largest |z|, -1 when there is no test */
};

/* a, b: results on the same grid; names: of the files, for messages. CML_E_INPUT names the field in which the
 * grids differ. *comparison is the caller's to clear; on failure it is cleared. */
CML_NODISCARD cml_status cml_compare(const struct cml_outcome *a, const struct cml_outcome *b,
                                     const char *const names[2], struct cml_comparison *comparison,
                                     struct cml_error *err);

void cml_comparison_clear(struct cml_comparison *comparison);

#endif
