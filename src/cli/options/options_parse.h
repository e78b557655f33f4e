/* Reads the command line. option_table.c lists the options, command_table.c the commands.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "options/options.h"

/* Reads argv[1..]. Options and operands may mix; "--" ends the options. Long options may not be abbreviated.
 * CML_E_INPUT with one line: an unknown option, one that does not belong to the command or engine, a wrong
 * value, or a wrong number of operands. Moves the operands to the front of argv. With --help or --version
 * refuses only unknown options and wrong values. */
CML_NODISCARD cml_status cml_options_parse(int argc, char **argv, struct cml_options *options,
                                           struct cml_error *err);
