/* Messages on a terminal. SPDX-License-Identifier: MIT */
#ifndef CML_PRINT_LINE_H
#define CML_PRINT_LINE_H

#include <stdio.h>

/* Prints a message and a line feed. Whatever users have written that stands in it cannot drive a terminal:
 * bytes that are no printable UTF-8 become \xNN. */
void cml_print_line(FILE *stream, const char *text);

#endif
