/* Writes error messages. SPDX-License-Identifier: MIT */
#include "base/status.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* First letters kept of a message that is too long. Its middle is left out, because names stand first and the
 * reason last. */
#define FIRST_PART 400

cml_status cml_fail(struct cml_error *err, cml_status status, const char *format, ...)
{
    /* The whole message, before its middle is cut out. There is room for two paths. The array is static,
     * because the stack of a thread may be as small as the array. */
    static _Thread_local char whole[16384];
    va_list args;
    va_start(args, format);
    vsnprintf(whole, sizeof whole, format, args);
    va_end(args);
    const size_t length = strlen(whole), most = sizeof err->text - 1;
    if (length <= most)
        strcpy(err->text, whole);
    else
        snprintf(err->text, sizeof err->text, "%.*s ... %s", FIRST_PART, whole,
                 whole + length - (most - FIRST_PART - strlen(" ... ")));
    err->status = status;
    return status;
}

/* True if the expected value itself may contain commas, as "x,y" does. */
static bool takes_commas(const char *expected)
{
    const char *comma = strchr(expected, ',');
    while (comma && (comma[1] == ' ' || comma[1] == '\0')) comma = strchr(comma + 1, ',');
    return comma != NULL;
}

const char *cml_number_hint(const char *value, const char *expected)
{
    const size_t whole = strspn(value, "+-0123456789.eE");
    if (whole == 0 || (value[whole] != ',' && value[whole] != ';') || takes_commas(expected)) return "";
    const char *part = value + whole + 1;
    if (value[whole] == ';') return ", without ;";
    if (part[strspn(part, "0123456789eE+-,")] != '\0') return "";
    return !*part || strncmp(expected, "a whole number", 14) == 0 ? ", without commas"
                                                                  : ", with a decimal point";
}

cml_status cml_fail_field(struct cml_error *err, const char *file, int line, const char *field,
                          const char *value, const char *expected)
{
    char where[32] = "";
    if (line > 0) snprintf(where, sizeof where, ":%d", line);
    if (!value || !*value)
        return cml_fail(err, CML_E_INPUT, "%s%s: %s is missing (expected %s)", file, where, field, expected);
    return cml_fail(err, CML_E_INPUT, "%s%s: %s = %.80s (expected %s%s)", file, where, field, value, expected,
                    cml_number_hint(value, expected));
}

cml_status cml_zeros(void *array, size_t count, size_t size, const char *what, struct cml_error *err)
{
    void *const made = calloc(count ? count : 1, size);
    memcpy(array, &made, sizeof made);
    return made ? CML_OK : cml_fail_memory(err, (double)count * (double)size, what);
}

cml_status cml_fail_memory(struct cml_error *err, double bytes, const char *what)
{
    return cml_fail(err, CML_E_INPUT, "out of memory: %.0f MiB for %s", bytes / 1048576.0, what);
}
