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
 * agree.
 *
 * Every array that both results have is tested, where it has errors: of quantities of the table that only .h5
 * files hold (maps, voxels, facets), these are read piece by piece. Numbers that are no weight of packets
 * (means, derivatives, totals by the twin) are never taken together. Without errors in both files there is no
 * test of grids over two axes and of what layers absorb (which MCML forms from z bins); A_z is left out where
 * one run did not tally absorption, and what has other bins in both. SPDX-License-Identifier: MIT */
#pragma once

#include "plot/compare_groups.h"

/* Whether a quantity of an outcome is compared: all that have errors are. */
bool cml_compare_tests(enum cml_quantity quantity);

/* a, b: results on the same grid; names: of the files, for messages, and to read what an outcome does not
 * hold where both are .h5. CML_E_INPUT names the field in which the grids differ, or what cannot be read.
 * *comparison is the caller's to clear; on failure it is cleared. */
CML_NODISCARD cml_status cml_compare(const struct cml_outcome *a, const struct cml_outcome *b,
                                     const char *const names[2], struct cml_comparison *comparison,
                                     struct cml_error *err);

void cml_comparison_clear(struct cml_comparison *comparison);
