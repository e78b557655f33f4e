/* What `clustermcml help` prints: made from the tables of commands, options and keys, and from the manual.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdio.h>

/* topic: a command, "options", "keys", "--NAME" of an option, a page of the manual, or a word that the manual
 * explains; NULL: the list of commands and pages. CML_E_INPUT for other topics; nothing is printed then. */
CML_NODISCARD cml_status cml_help_print(FILE *stream, const char *topic, struct cml_error *err);
