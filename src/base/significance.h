/* Probabilities of deviations: the few formulas needed to compare noisy numbers. SPDX-License-Identifier:
 * MIT */
#pragma once

/* Returns the normal deviate with the same tail probability as Student's t with `freedom` degrees of freedom;
 * t itself if `freedom` is infinite. Wallace's approximation [Ann. Math. Stat. 30 (1959) 1124]. For 63 or
 * more degrees and |t| <= 10 the tail probability has a relative error below 2 % (unit.significance). */
double cml_normal_of_student(double t, double freedom);

/* Returns the probability that a standard normal deviate lies further from 0 than z. */
double cml_two_sided(double z);

/* Returns Sidak's probability that the smallest of `tests` p-values is p or less if nothing differs; 1 for no
 * tests. Exact for independent tests. Never too small for two-sided tests of jointly normal deviates,
 * whatever their correlations [Sidak, J. Am. Stat. Assoc. 62 (1967) 626]. */
double cml_sidak(double p, double tests);
