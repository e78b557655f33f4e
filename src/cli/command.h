/* Declares the functions of the commands. Each takes the parsed options and returns the exit code of the
 * program. options->operands[0] is the first word behind the command's name. SPDX-License-Identifier: MIT */
#pragma once

#include "cli/run/load.h"

#define CML_DECLARE(NAME, name, ...)                                                                         \
    CML_NODISCARD cml_status cml_command_##name(const struct cml_options *options, struct cml_error *err);
#define CML_NONE(...)
CML_COMMANDS(CML_DECLARE, CML_NONE)
#undef CML_DECLARE
#undef CML_NONE

/* Goals of pilots behind the totals (cml_goals): the expected Tt (P15), and the quantity of setup->error_of.
 */
enum { CML_PILOT_EXPECTED = CML_NUM_GOALS, CML_PILOT_NAMED, CML_PILOT_GOALS };

/* One round of a pilot: its photons, and the relative standard errors of all goals; INFINITY if the round saw
 * nothing. */
struct cml_pilot_round {
    uint64_t photons;
    double error[CML_PILOT_GOALS];
};

#define CML_PILOT_MOST_ROUNDS 48

/* Pilots: short runs that show how errors fall and how fast the engine is. Zeroed: none was flown. */
struct cml_pilot {
    int num_rounds;
    struct cml_pilot_round round[CML_PILOT_MOST_ROUNDS]; /* [num_rounds], each longer than the one before */
    double photons_per_s;                                /* speed of the last round, all ranks together */
    int threads;                                         /* threads of a rank */
    /* goals too small for --target-error to wait for */
    bool faint[CML_NUM_GOALS];
};

/* Flies rounds from photon 0 on, each `growth` times as long as the one before. Ends at setup->photons
 * photons; or, if that is 0, when all rounds would take longer than about `seconds`, with the opening of the
 * engine. Flies at least two rounds, unless they take setup->most_seconds each. Collective; the pilot of rank
 * 0 counts. Fails as cml_run does. */
CML_NODISCARD cml_status cml_pilot_fly(const struct cml_run_setup *setup, double seconds, int growth,
                                       struct cml_pilot *pilot, struct cml_error *err);

/* Returns the photons after which a goal has this relative standard error, at least one per batch.
 * Interpolates between rounds; beyond the pilot it takes errors to fall with the root of the photons, an
 * upper estimate where draws are evenly spread. INFINITY if the last round saw fewer than four packets.
 * Errors of rounds are known to 9 % (64 batches), so the photons to some 20 %; with n < 25 packets to 1 /
 * sqrt(n). */
double cml_pilot_photons(const struct cml_pilot *pilot, int goal, double error);
