/* Text of `clustermcml help`, made from the tables of commands, options and keys, and from the manual.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdio.h>

/* Prints the help on a topic: a command, "options", "keys", an option "--NAME", a page of the manual, or a
 * word that the manual explains. topic NULL: the list of commands and pages. CML_E_INPUT: another topic;
 * nothing is printed. */
CML_NODISCARD cml_status cml_help_print(FILE *stream, const char *topic, struct cml_error *err);
