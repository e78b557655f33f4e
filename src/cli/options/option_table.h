/* The options of the program: the one place for their names, arguments, commands, help and limits.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "cli/options/option.h"

/* In the order of the help. */
extern const struct cml_option cml_option_table[];
extern const size_t cml_option_count;

/* The option of that name (length bytes), and that of a letter; NULL when there is none. Where several share
 * the letter, the one of the command, else the first. */
const struct cml_option *cml_option_find(const char *name, size_t length);
const struct cml_option *cml_option_of_letter(char letter, enum cml_command command);

/* The names of its commands, "run, plan"; cut at size bytes. */
void cml_option_commands(const struct cml_option *option, char *text, size_t size);

/* As cml_command_guess. */
const char *cml_option_guess(const char *name, size_t length);
