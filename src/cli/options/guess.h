/* Which of some names was probably meant by a word that is none of them. SPDX-License-Identifier: MIT */
#ifndef CML_GUESS_H
#define CML_GUESS_H

#include <stddef.h>

/* The best name so far; zero before the first one is offered. */
struct cml_guess {
    const char *word; /* [length] */
    size_t length;
    const char *nearest;
    size_t distance;      /* of that: letters to be changed, added or left out */
    const char *complete; /* a name that begins with the word */
    int completions;      /* how many do */
};

/* Looks at one more name. Words and names of more than 63 letters are like none. */
void cml_guess_offer(struct cml_guess *guess, const char *name);

/* The only name that begins with the word; else the nearest one, if at most two letters of more than three
 * are wrong; else NULL. */
const char *cml_guess_best(const struct cml_guess *guess);

#endif
