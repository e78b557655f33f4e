/* All options that decide the bits of a result, besides the bytes of its input. One row per option; the
 * identity of a run, the head of an .mco, the attributes of an .h5 and JSON are made from these rows.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "result/quantity.h"

#include <stdio.h>

enum { CML_AS_WORD = 8 };
/* Size in bytes of the checksum of a run's identity (run/identity.h) as text. */
enum { CML_IDENTITY_SUM = 17 };

/* clang-format off */
/* Columns: the option's name; its value as a number, an expression in the variables setup, options, surface
 * and flat of run/identity.c; and the files besides the identity that have the option under its name
 * (CML_IN_H5, CML_IN_JSON; with CML_AS_WORD they have the word from the head of an .mco in place of the
 * number). The last three columns are texts for the head of an .mco: the text before the value, the text
 * for the value 0, and the text for other values. With NULL as the text before it, the option is not in the
 * head; an empty text for a value leaves that value out. */
#define CML_OPTIONS_OF_BITS(D)                                                                                       \
    D(seed, options->seed, CML_IN_H5 | CML_IN_JSON, ", seed ", "%.0f", "%.0f")                                 \
    D(run, options->run + 1, CML_IN_H5, ", run ", "%.0f", "%.0f")                                              \
    D(reentry, options->reentry, CML_IN_H5, ", ", "packets are scored at their first exit",                          \
      "packets that leave may re-enter")                                                                 \
    D(sampling, options->lattice, CML_IN_H5 | CML_IN_JSON | CML_AS_WORD, "\n# sampling ", "random", "lattice")               \
    D(roulette_below, options->roulette.below, CML_IN_H5, ", roulette ", "of original MCML", "below %g")       \
    D(roulette_weight, options->roulette.weight, CML_IN_H5, " to ", "", "%g")                                  \
    D(photons, setup->photons, 0, NULL, NULL, NULL)                                                            \
    D(target_error, setup->target_error, 0, NULL, NULL, NULL)                                                  \
    D(absorption, options->absorption || options->rows.times, 0, NULL, NULL, NULL)                                    \
    D(reweight, options->rows.count > 0, 0, NULL, NULL, NULL)                                                  \
    D(derivatives, options->derivatives, 0, NULL, NULL, NULL)                                                  \
    D(flat, flat, 0, NULL, NULL, NULL)                                                                         \
    D(boundaries, surface->force, 0, NULL, NULL, NULL)                                                         \
    D(tolerance, surface->tolerance, 0, NULL, NULL, NULL)                                                      \
    D(may_flatten, surface->may_flatten, 0, NULL, NULL, NULL)                                                  \
    D(normals, surface->tessellation.normals, 0, NULL, NULL, NULL)                                             \
    D(inscribed, surface->tessellation.inscribed, 0, NULL, NULL, NULL)                                         \
    D(search, surface->search, 0, NULL, NULL, NULL)
/* clang-format on */

#define CML_ENUMERATOR(name, ...) CML_DECIDES_##name,
enum cml_option_of_bits { CML_OPTIONS_OF_BITS(CML_ENUMERATOR) CML_NUM_OPTIONS_OF_BITS };
#undef CML_ENUMERATOR

/* A row of CML_OPTIONS_OF_BITS. */
struct cml_option_info {
    const char *name;
    unsigned where;
    const char *before, *zero, *other;
};
extern const struct cml_option_info cml_options_of_bits[CML_NUM_OPTIONS_OF_BITS];

/* The options' values in one run. Seeds and photons are at most 2^53, which a double holds. */
struct cml_provenance {
    char engine[32];            /* name of the engine; "": not known, or several */
    const char *aim, *error_of; /* texts of the options --aim and --error-of; NULL: not given, or not known */
    double value[CML_NUM_OPTIONS_OF_BITS]; /* value of each option; NAN: not known */
};

/* Returns the word for an option's value in the head of an .mco, if the option has words. */
const char *cml_option_word(enum cml_option_of_bits option, double value);

/* Writes a line "NAME VALUE", or "no NAME", for the engine and each option. Numbers have 17 digits, which
 * distinguish any two doubles. */
void cml_provenance_identify(FILE *out, const struct cml_provenance *provenance);

/* Writes the lines in the head of an .mco. */
void cml_provenance_print(FILE *out, const struct cml_provenance *provenance);
