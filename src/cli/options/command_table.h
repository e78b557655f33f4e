/* The commands of the program: their names, operands and texts. What they do stands in cli/command_NAME.c.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

enum cml_command {
    CML_COMMAND_RUN,
    CML_COMMAND_PLAN,
    CML_COMMAND_CHECK,
    CML_COMMAND_EXACT,
    CML_COMMAND_MESH,
    CML_COMMAND_TRACE,
    CML_COMMAND_CROSSCHECK,
    CML_COMMAND_FURNACE,
    CML_COMMAND_COMPARE,
    CML_COMMAND_MERGE,
    CML_COMMAND_PLOT,
    CML_COMMAND_DEVICES,
    CML_COMMAND_HELP,
    CML_NUM_COMMANDS
};

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
