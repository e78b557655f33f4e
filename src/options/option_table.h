/* The options of the program: the only place of their names, arguments, commands, help and ranges.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "options/option.h"

/* All options in the order of the help. */
extern const struct cml_option cml_option_table[];
extern const size_t cml_option_count;

/* Return an option by its name (`length` bytes), or by its letter; NULL: none. If several options share the
 * letter: that of the command, else the first. */
const struct cml_option *cml_option_find(const char *name, size_t length);
const struct cml_option *cml_option_of_letter(char letter, enum cml_command command);

/* Writes the names of an option's commands, "run, plan", cut off at `size` bytes. */
void cml_option_commands(const struct cml_option *option, char *text, size_t size);

/* Returns the option that was probably meant (see cml_command_guess); NULL: none. */
const char *cml_option_guess(const char *name, size_t length);
