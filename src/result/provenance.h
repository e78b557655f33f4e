/* What decides the bits of a result besides the bytes of its input: one row for each option, and the identity
 * of a run, the head of an .mco, the attributes of an .h5 and JSON walk these rows.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "result/quantity.h"

#include <stdio.h>

enum { CML_AS_WORD = 8 };
enum { CML_IDENTITY_SUM = 17 }; /* bytes of the checksum of a run's identity (run/identity.h), as text */

/* clang-format off */
/* name; the value, a number, as run/identity.c finds it among setup, options, surface and flat; where it stands beside the
 * identity (CML_IN_H5, CML_IN_JSON: under its name, with CML_AS_WORD as in the head of an .mco); in the head of an .mco what stands before it, the value 0, and any
 * other (NULL: not there; an empty text: nothing at all) */
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

struct cml_option_info {
    const char *name;
    unsigned where;
    const char *before, *zero, *other;
};
extern const struct cml_option_info cml_options_of_bits[CML_NUM_OPTIONS_OF_BITS];

/* Seeds and photons are at most 2^53, which a double holds. */
struct cml_provenance {
    char engine[32];            /* its name; "": not known, or several */
    const char *aim, *error_of; /* of a run, as these options say it; NULL: not given, or not known */
    double value[CML_NUM_OPTIONS_OF_BITS]; /* NAN: not known */
};

/* The form of the value in the head of an .mco, where it is a word. */
const char *cml_option_word(enum cml_option_of_bits option, double value);

/* A line "NAME VALUE", or "no NAME", for the engine and each option, numbers with 17 digits, which tell any
 * two doubles apart. */
void cml_provenance_identify(FILE *out, const struct cml_provenance *provenance);

/* The lines of the head of an .mco. */
void cml_provenance_print(FILE *out, const struct cml_provenance *provenance);
