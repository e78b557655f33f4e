/* What an option is: one row of the table. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "cli/options/command_table.h"

#include <stddef.h>

struct cml_options;

struct cml_option {
    const char *name; /* without the two dashes */
    char letter;      /* behind one dash, 0: none; several options may share one, each of other commands */
    const char *argument; /* as the help shows it; NULL: it takes none */
    unsigned commands;    /* 1u << enum cml_command of those it belongs to */
    const char *engine;   /* the only one that it means something to; NULL: any */
    const char *help;
    /* Takes the value. `value` is borrowed for as long as the options live; NULL where the option takes none.
     */
    cml_status (*read)(const struct cml_option *option, const char *value, struct cml_options *options,
                       struct cml_error *err);
    /* For `read`, where it is one that several options share (option_values.h): */
    size_t member, size; /* offset in struct cml_options of what is set, and its bytes */
    double least, most;  /* a number's limits, both among the values; of a flag its value */
    const char *words;   /* the values that there are, in the order of their numbers, parted by blanks; or
                            what is expected of a number */
    const char *title;   /* of the group of options that begins with this one; NULL: it goes on */
};

/* Whether an option may stand behind a command. */
static inline bool cml_option_belongs(const struct cml_option *option, enum cml_command command)
{
    return option->commands >> command & 1;
}
