/* Safe printing of text that users have written, such as file names, on a terminal. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stdio.h>

/* Prints a message and a line feed. Control characters, invisible characters and bytes that are no valid
 * UTF-8 are printed as \xNN, so that text from users cannot control the terminal or hide. */
void cml_print_line(FILE *stream, const char *text);

/* Escapes the same characters, except line feeds and tabs, in everything written to standard output from now
 * on. With `json` they become \uNNNN, which a JSON reader decodes. Returns CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_escape_output(bool json, struct cml_error *err);

/* True if standard output is a pipe whose reader has closed it, so that something written was lost. */
bool cml_output_unread(void);
