/* JSON: names of files, which may hold any bytes while it is UTF-8, numbers, and records on a line.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <jansson.h>
#include <stdio.h>

/* A new string: the name, or, where it is not UTF-8, the name with every byte beyond ASCII written as \xNN.
 * NULL when memory runs out. */
json_t *cml_json_name(const char *name);

/* JSON cannot say NaN, the error of one packet, nor infinity: null. NULL when memory runs out. */
json_t *cml_json_real(double value);

/* The object, or NULL, on one line; it is freed. CML_E_INPUT when memory runs out, or had before. */
CML_NODISCARD cml_status cml_json_print(FILE *stream, json_t *object, struct cml_error *err);
