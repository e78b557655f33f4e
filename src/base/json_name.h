/* Values of JSON records: file names of any bytes, numbers that may be NaN, and printing of one record per
 * line. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <jansson.h>
#include <stdio.h>

/* Returns a new JSON string of the name. In a name that is not UTF-8, every byte beyond ASCII becomes \xNN.
 * Returns NULL if memory runs out. */
json_t *cml_json_name(const char *name);

/* Returns a JSON number, or null for NaN and infinity, which JSON does not have. An error estimated from one
 * packet is NaN. Returns NULL if memory runs out. */
json_t *cml_json_real(double value);

/* Prints the object on one line and frees it. Returns CML_E_INPUT if the object is NULL, because memory ran
 * out before, or if memory runs out now. */
CML_NODISCARD cml_status cml_json_print(FILE *stream, json_t *object, struct cml_error *err);
