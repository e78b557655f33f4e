/* The commands of the program; each takes the parsed options and returns what becomes the exit code.
 * options->operands[0] is the first word after the command's name.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "cli/load/scenes.h"

#define CML_DECLARE(NAME, name, ...)                                                                         \
    CML_NODISCARD cml_status cml_command_##name(const struct cml_options *options, struct cml_error *err);
#define CML_NONE(...)
CML_COMMANDS(CML_DECLARE, CML_NONE)
#undef CML_DECLARE
#undef CML_NONE

/* Behind the goals what is expected of Tt (P15), and what setup->error_of names. */
enum { CML_PILOT_EXPECTED = CML_NUM_GOALS, CML_PILOT_NAMED, CML_PILOT_GOALS };

/* A run of so many photons, and the relative standard errors that it had; INFINITY where it saw nothing. */
struct cml_pilot_round {
    uint64_t photons;
    double error[CML_PILOT_GOALS];
};

#define CML_PILOT_MOST_ROUNDS 48

/* Zeroed: none was flown. */
struct cml_pilot {
    int num_rounds;
    struct cml_pilot_round round[CML_PILOT_MOST_ROUNDS]; /* longer and longer */
    double photons_per_s;                                /* of the last, on all ranks */
    int threads;                                         /* of a rank */
    bool faint[CML_NUM_GOALS];                           /* what --target-error does not wait for */
};

/* Flies rounds of setup->engine from photon 0 on, each `growth` times as long as the one before, up to
 * setup->photons, or, where that is 0, as long as they fit into about so many seconds together, opening of
 * the engine included; two at least, where they do not take setup->most_seconds each. Collective; rank 0's
 * pilot counts. Fails as cml_run does. */
CML_NODISCARD cml_status cml_pilot_fly(const struct cml_run_setup *setup, double seconds, int growth,
                                       struct cml_pilot *pilot, struct cml_error *err);

/* Photons after which a goal (cml_goals, or one of those above) has a relative standard error, at least one
 * for every batch: between the rounds from which on all reach it by interpolation; else as if errors fell
 * with the root of the photons, which beyond the pilot is an upper estimate where draws are evenly spread.
 * INFINITY where the last round saw fewer than four packets. The errors of rounds are known to 9 % (64
 * batches), so the photons to some 20 %; of n packets, fewer than 25, to 1 / sqrt(n). */
double cml_pilot_photons(const struct cml_pilot *pilot, int goal, double error);
