/* From deviates to probabilities: the few formulas that comparing noisy numbers needs.
 * SPDX-License-Identifier: MIT */
#pragma once

/* The normal deviate with the same tail as Student's t with `freedom` degrees of freedom (infinite: t
 * itself). Wallace's approximation [Ann. Math. Stat. 30 (1959) 1124]; for 63 or more degrees and |t| <= 10
 * the tail's probability is right within 2 % of itself (unit.significance). */
double cml_normal_of_student(double t, double freedom);

/* Probability that a standard normal deviate lies further from 0 than z does. */
double cml_two_sided(double z);

/* Sidak: the probability that the smallest of `tests` p-values is p or less when nothing differs. Exact for
 * independent tests; never too small for the two-sided tests of jointly normal deviates, whatever their
 * correlations [Sidak, J. Am. Stat. Assoc. 62 (1967) 626]. 1 for no tests. */
double cml_sidak(double p, double tests);
