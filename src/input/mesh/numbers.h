/* Numbers of mesh files, taken one after another from the words of a line or from binary data.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "input/mesh/polygons.h"

/* Types of numbers in binary data: whole numbers of 1, 2 and 4 bytes, with a sign or without one (U), and
 * reals of IEEE 754. */
enum cml_number { CML_INT8, CML_UINT8, CML_INT16, CML_UINT16, CML_INT32, CML_UINT32, CML_FLOAT, CML_DOUBLE };

/* A place in a line of text, or in binary data. */
struct cml_numbers {
    struct cml_text *text;
    char *cursor; /* the rest of the line, or the next byte of the data */
    int line;     /* number of the line; 0 in binary data */
    bool binary;
    bool big; /* the highest byte of a binary number comes first */
    struct cml_error *err;
};

/* Decodes a binary number byte by byte: a file's order of bytes is fixed while the machine's is not, and
 * addresses need not be aligned. big: the first byte is the highest. */
double cml_number_decode(const char *data, enum cml_number type, bool big);

/* Goes to the next line that is not blank. False: the text ends. */
bool cml_numbers_next_line(struct cml_numbers *in);

/* Cuts the next word off the line. Quotation marks mean nothing. NULL: only blanks are left. */
char *cml_numbers_word(struct cml_numbers *in);

/* Refuses a value. Names the line, or the byte of binary data. */
CML_NODISCARD cml_status cml_numbers_fail(const struct cml_numbers *in, const char *name, const char *value,
                                          const char *expected);

/* Takes the next number. most: the largest whole number that is allowed; INFINITY allows all finite numbers,
 * and NAN whatever stands there, which is then not read from a text. */
CML_NODISCARD cml_status cml_numbers_take(struct cml_numbers *in, enum cml_number type, const char *name,
                                          double most, double *value);

/* Takes x, y and z, floats in binary data, and adds the vertex. */
CML_NODISCARD cml_status cml_numbers_take_vertex(struct cml_numbers *in, struct cml_polygons *polygons);
