/* SPDX-License-Identifier: MIT */
#include "base/json_name.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

json_t *cml_json_name(const char *name)
{
    json_t *string = json_string(name);
    if (string) return string;
    char *escaped = malloc(4 * strlen(name) + 1), *out = escaped;
    if (!escaped) return NULL;
    for (; *name; name++) {
        const unsigned char byte = (unsigned char)*name;
        out += byte < 0x80 ? sprintf(out, "%c", byte) : sprintf(out, "\\x%02x", byte);
    }
    *out = '\0';
    string = json_string(escaped);
    free(escaped);
    return string;
}
