/* What `clustermcml help` prints: made from the tables of commands and options, and from texts that are built
 * into the program. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdio.h>

/* topic: a command, "options", "--NAME" of one of them, or the name of a text; NULL: the list of commands.
 * CML_E_INPUT when there is no such topic; nothing is printed then. */
CML_NODISCARD cml_status cml_help_print(FILE *stream, const char *topic, struct cml_error *err);

/* A text of the sources, as it stands there (help_texts.cmake writes the list). */
struct cml_help_text {
    const char *name, *text;
};

/* The last one has no name. */
extern const struct cml_help_text cml_help_texts[];
