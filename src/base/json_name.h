/* Names of files in JSON, which is UTF-8, while a name may hold any bytes. SPDX-License-Identifier: MIT */
#ifndef CML_JSON_NAME_H
#define CML_JSON_NAME_H

#include <jansson.h>

/* A new string: the name, or, where it is not UTF-8, the name with every byte beyond ASCII written as \xNN.
 * NULL when memory runs out. */
json_t *cml_json_name(const char *name);

#endif
