/* Declares the functions of the commands. Each takes the parsed options and returns the exit code of the
 * program. options->operands[0] is the first word behind the command's name. SPDX-License-Identifier: MIT */
#pragma once

#include "flights/load.h"

#define CML_DECLARE(NAME, name, ...)                                                                         \
    CML_NODISCARD cml_status cml_command_##name(const struct cml_options *options, struct cml_error *err);
#define CML_NONE(...)
CML_COMMANDS(CML_DECLARE, CML_NONE)
#undef CML_DECLARE
#undef CML_NONE
