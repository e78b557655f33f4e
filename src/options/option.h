/* An option of the command line: one row of the table (option_table.c). SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "options/command_table.h"

#include <stddef.h>

struct cml_options;

/* Bits of cml_option.commands behind those of commands: the C library takes the option for a flight, or for
 * the reading of a scene. */
enum { CML_OPTION_OF_FLIGHT = 1 << 29, CML_OPTION_OF_READING = 1 << 30 };

struct cml_option {
    const char *name; /* name without the two dashes */
    /* Letter behind one dash; 0: none. Options of different commands may share a letter. */
    char letter;
    const char *argument; /* name of the value in the help; NULL: the option takes none */
    unsigned commands;    /* bits 1u << enum cml_command of the commands that it belongs to */
    const char *engine;   /* the only engine that the option has a meaning for; NULL: all */
    const char *help;
    /* Reads the value. The value is borrowed for as long as the options live; NULL if the option takes none.
     */
    cml_status (*read)(const struct cml_option *option, const char *value, struct cml_options *options,
                       struct cml_error *err);
    /* The members below are for functions `read` that several options share (option_values.h). */
    size_t member, size; /* offset of the member of struct cml_options that is set, and its size in bytes */
    double least, most;  /* range of a number, both ends included; `least` is the value of a flag */
    /* Allowed words, separated by blanks, in the order of their numbers; or the text that describes the
     * expected number. */
    const char *words;
    const char *title; /* title of the group of options that begins here; NULL: the group continues */
};

/* True if an option may stand behind a command. */
static inline bool cml_option_belongs(const struct cml_option *option, enum cml_command command)
{
    return option->commands >> command & 1;
}
