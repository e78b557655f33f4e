/* Makes values of JSON records and prints the records. SPDX-License-Identifier: MIT */
#include "base/json_name.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Returns a JSON string of a file name. JSON allows UTF-8 only, so a name that is not UTF-8 gets each byte
 * above 127 written as four letters like \xe4. */
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

json_t *cml_json_real(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

cml_status cml_json_print(FILE *stream, json_t *object, struct cml_error *err)
{
    char *text = object ? json_dumps(object, JSON_COMPACT) : NULL;
    json_decref(object);
    if (!text) return cml_fail_memory(err, 1, "the JSON record");
    fprintf(stream, "%s\n", text);
    free(text);
    return CML_OK;
}
