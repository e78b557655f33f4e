/* SPDX-License-Identifier: MIT */
#include "cli/options/guess.h"

#include <string.h>

enum { LONGEST = 63 };

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Levenshtein's distance, a row of its table at a time. */
static size_t distance(const char *a, size_t a_length, const char *b, size_t b_length)
{
    size_t row[LONGEST + 1];
    for (size_t j = 0; j <= b_length; j++) row[j] = j;
    for (size_t i = 1; i <= a_length; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            const size_t above = row[j];
            row[j] = least(least(above, row[j - 1]) + 1, diagonal + (a[i - 1] != b[j - 1]));
            diagonal = above;
        }
    }
    return row[b_length];
}

void cml_guess_offer(struct cml_guess *guess, const char *name)
{
    const size_t length = strlen(name);
    if (length > LONGEST || guess->length > LONGEST || guess->length == 0) return;
    if (strncmp(name, guess->word, guess->length) == 0) {
        guess->complete = name;
        guess->completions++;
    }
    const size_t d = distance(guess->word, guess->length, name, length);
    if (guess->nearest && d >= guess->distance) return;
    guess->nearest = name;
    guess->distance = d;
}

const char *cml_guess_best(const struct cml_guess *guess)
{
    if (guess->completions == 1) return guess->complete;
    return guess->nearest && guess->length > 3 && guess->distance <= 2 ? guess->nearest : NULL;
}
