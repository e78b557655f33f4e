/* Parts that the tests of the numerics share: random numbers from the program's own generator, and the
 * p-value of a chi-square. Every sequence is fixed by its seed, so that a test always passes or always
 * fails.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "lib/sanitized.h"
#include "rng.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof(array)[0]))

struct dice {
    struct cml_stream stream;
    uint64_t rolls;
};

static inline struct dice dice_new(uint32_t seed)
{
    const struct dice dice = {.stream = {.key = {seed, 0xd1ceu, 0, 0}}};
    return dice;
}

static inline uint32_t dice_word(struct dice *dice)
{
    const uint64_t roll = dice->rolls++;
    return cml_threefry(dice->stream, (uint32_t)(roll >> 2), (uint32_t)(roll >> 34), 0, 0).w[roll & 3];
}

/* Returns a uniform number in (0, 1) with 53 bits. */
static inline double dice_uniform(struct dice *dice)
{
    const uint64_t high = dice_word(dice), low = dice_word(dice);
    return ((double)((high << 32 | low) >> 12) + 0.5) * 0x1p-52;
}

static inline double dice_between(struct dice *dice, double low, double high)
{
    return low + (high - low) * dice_uniform(dice);
}

static inline int dice_below(struct dice *dice, int n)
{
    return (int)((uint64_t)dice_word(dice) * (uint64_t)n >> 32);
}

/* Writes a direction that is uniform over the sphere. */
static inline void dice_direction(struct dice *dice, double u[3])
{
    const double z = dice_between(dice, -1, 1), phi = dice_between(dice, 0, 6.283185307179586);
    const double s = sqrt((1 - z) * (1 + z));
    u[0] = s * cos(phi);
    u[1] = s * sin(phi);
    u[2] = z;
}

/* Returns the chi-square of counts against expected numbers. */
static inline double chi_square(const long *count, const double *expected, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += ((double)count[i] - expected[i]) * ((double)count[i] - expected[i]) / expected[i];
    return sum;
}

/* Returns the probability of a chi-square above the value (Wilson and Hilferty's normal approximation). */
static inline double chi_square_p(double value, int freedom)
{
    const double k = 2.0 / (9.0 * freedom);
    const double z = (cbrt(value / freedom) - (1 - k)) / sqrt(k);
    return 0.5 * erfc(z / sqrt(2.0));
}

/* Fails the test if the counts fit with p < 1e-4, or fit better than chance allows. */
static inline void assert_fits(const char *what, const long *count, const double *expected, int n)
{
    const double p = chi_square_p(chi_square(count, expected, n), n - 1);
    if (!(p > 1e-4 && p < 1 - 1e-4)) fail_msg("%s: p = %g of %d bins", what, p, n);
}

static inline void assert_flat(const char *what, const long *count, int n)
{
    double expected[1024], total = 0;
    assert_true(n <= COUNT(expected));
    for (int i = 0; i < n; i++) total += (double)count[i];
    for (int i = 0; i < n; i++) expected[i] = total / n;
    assert_fits(what, count, expected, n);
}

/* Checks |value - wanted| <= tolerance, with the numbers in the message. */
static inline void assert_near(const char *what, double value, double wanted, double tolerance)
{
    if (!(fabs(value - wanted) <= tolerance))
        fail_msg("%s: %.17g, wanted %.17g within %g", what, value, wanted, tolerance);
}

/* Damages a copy of a file with up to 3 edits: one edit in `odds` cuts the file, the others change a byte.
 * Returns the new size. */
static inline size_t dice_damage(struct dice *dice, char *bytes, size_t size, int odds)
{
    for (int edits = dice_below(dice, 4); edits > 0; edits--) {
        const size_t at = (size_t)dice_below(dice, (int)size);
        if (dice_below(dice, odds))
            bytes[at] = (char)dice_below(dice, 256);
        else
            size = at + 1;
    }
    return size;
}
