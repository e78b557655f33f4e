/* Reads the command line. option_table.c says which options there are, command_table.c which commands.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "cli/options/options.h"

/* Reads argv[1..]; options and operands may mix, and "--" ends the options. Long options are written out: no
 * abbreviations. CML_E_INPUT with one line for an option that is unknown, or does not belong to the command
 * or the engine, or has a wrong value, and for a wrong number of operands. argv is sorted: the operands come
 * to its front. With --help or --version only unknown options and wrong values are refused. */
CML_NODISCARD cml_status cml_options_parse(int argc, char **argv, struct cml_options *options,
                                           struct cml_error *err);
