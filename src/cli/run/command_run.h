/* clustermcml run. SPDX-License-Identifier: MIT */
#ifndef CML_COMMAND_RUN_H
#define CML_COMMAND_RUN_H

#include "cli/options/options.h"

/* Flies all runs of the file that is the operand, and writes their results. Collective. */
CML_NODISCARD cml_status cml_command_run(const struct cml_options *options, struct cml_error *err);

#endif
