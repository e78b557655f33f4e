/* The commands of the program: names, operands and texts. cli/command_NAME.c has their functions.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

/* All commands in the order of the help: enumerator, function cml_command_NAME, and true if the command
 * starts MPI and all ranks call it; else rank 0 alone works, without MPI. PYTHON: a command of the Python
 * package, without a function here. */
#define CML_COMMANDS(C, PYTHON)                                                                              \
    C(RUN, run, true)                                                                                        \
    C(PLAN, plan, true)                                                                                      \
    C(CHECK, check, false)                                                                                   \
    C(EXACT, exact, false)                                                                                   \
    C(MESH, mesh, false)                                                                                     \
    C(TRACE, trace, false)                                                                                   \
    C(CROSSCHECK, crosscheck, true)                                                                          \
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
    const char *operands; /* operands as the help shows them; "" for none */
    int least, most;      /* numbers of operands allowed */
    const char *summary;  /* summary of half a line */
    const char *text;     /* description, one paragraph */
    const char *example;  /* examples, each ended by a line feed */
};

/* [CML_NUM_COMMANDS] table of all commands */
extern const struct cml_command_def cml_commands[];

/* Returns the command of that name, or CML_NUM_COMMANDS. */
enum cml_command cml_command_find(const char *name);

/* Returns the name that was probably meant: the only one that begins with the word, else the one that differs
 * by at most two letters. NULL: none. */
const char *cml_command_guess(const char *word);
