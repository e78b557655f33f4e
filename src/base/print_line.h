/* What users have written, on a terminal. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stdio.h>

/* Prints a message and a line feed. Whatever users have written that stands in it cannot drive a terminal,
 * nor be there unseen: bytes that are no printable UTF-8 become \xNN. */
void cml_print_line(FILE *stream, const char *text);

/* From here on standard output is so, too, but for its line feeds and tabs; json: such characters become
 * \uNNNN, which a reader of JSON turns back. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_escape_output(bool json, struct cml_error *err);

/* Whether something was written to it that nobody would read: a pipe whose other end is closed. */
bool cml_output_unread(void);
