/* The commands of the program: their names, operands and texts. What they do stands in cli/command_NAME.c.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

/* In the order of the help: enumerator, function cml_command_NAME, and whether all ranks work; else rank 0
 * alone does, and the others wait for its status. PYTHON: a command of the Python package, with no
 * function here. */
#define CML_COMMANDS(C, PYTHON)                                                                              \
    C(RUN, run, true)                                                                                        \
    C(PLAN, plan, true)                                                                                      \
    C(CHECK, check, false)                                                                                   \
    C(EXACT, exact, false)                                                                                   \
    C(MESH, mesh, false)                                                                                     \
    C(TRACE, trace, false)                                                                                   \
    C(CROSSCHECK, crosscheck, false)                                                                         \
    C(FURNACE, furnace, true)                                                                                \
    PYTHON(COMPARE, compare)                                                                                 \
    C(MERGE, merge, false)                                                                                   \
    PYTHON(PLOT, plot)                                                                                       \
    PYTHON(VIEW, view)                                                                                       \
    PYTHON(BRDF, brdf)                                                                                       \
    PYTHON(PROFILE, profile)                                                                                 \
    C(DEVICES, devices, false)                                                                               \
    C(HELP, help, false)

#define CML_ENUMERATOR(NAME, ...) CML_COMMAND_##NAME,
enum cml_command { CML_COMMANDS(CML_ENUMERATOR, CML_ENUMERATOR) CML_NUM_COMMANDS };
#undef CML_ENUMERATOR

struct cml_command_def {
    const char *name;
    const char *operands; /* as the help shows them, "" where there are none */
    int least, most;      /* how many */
    const char *summary;  /* half a line */
    const char *text;     /* what it does, as one paragraph */
    const char *example;  /* one line each, each ended by a line feed */
};

/* [CML_NUM_COMMANDS] */
extern const struct cml_command_def cml_commands[];

/* The command of that name, CML_NUM_COMMANDS when there is none. */
enum cml_command cml_command_find(const char *name);

/* The name that was probably meant: one that begins with the word and is the only one that does, else the one
 * that is at most two letters away. NULL: none. */
const char *cml_command_guess(const char *word);
