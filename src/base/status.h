/* Errors as values.
 * Every function that can fail returns a cml_status and writes one line into its `err`; only `main` prints it
 * and turns the status into the exit code. The numbers are the exit codes of the command line.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdlib.h>
#include <string.h>

typedef enum cml_status {
    CML_OK = 0,
    CML_E_DIFFER = 1,   /* a comparison found a difference */
    CML_E_INPUT = 2,    /* usage or input, including requests that do not fit into memory */
    CML_E_DEVICE = 3,   /* no device, or the device refused */
    CML_E_NUMERIC = 4,  /* too many lost packets, or a weight balance that is not 0 */
    CML_E_IO = 5,       /* a file could not be written or read to its end */
    CML_E_STOPPED = 75, /* stopped by a signal, can be resumed */
} cml_status;

struct cml_error {
    cml_status status;
    char text[1024]; /* for cml_print_line: it may hold what users have written */
};

#define CML_NODISCARD __attribute__((warn_unused_result))
#define CML_PRINTF(fmt, args) __attribute__((format(printf, fmt, args)))

/* Returns from the calling function with the status of `call` unless it is CML_OK. */
#define CML_TRY(call)                                                                                        \
    do {                                                                                                     \
        const cml_status cml_try_status_ = (call);                                                           \
        if (cml_try_status_ != CML_OK) return cml_try_status_;                                               \
    } while (0)

/* What a local variable owns ends with its scope, wherever that is left: it is freed, or `end` is called with
 * its address. From its declaration on the variable is empty, or owns something. */
#define CML_AT_END(end) __attribute__((cleanup(end)))
#define CML_FREED CML_AT_END(cml_free_owned)

static inline void cml_free_owned(void *variable)
{
    void *owned;
    memcpy(&owned, variable, sizeof owned);
    free(owned);
}

/* Writes the message (where it is longer than err->text, without its middle) and returns `status`. */
CML_NODISCARD CML_PRINTF(3, 4) cml_status
    cml_fail(struct cml_error *err, cml_status status, const char *format, ...);

/* What a number that others write so lacks or has too much: "0,5", "1,000", "1.4;"; "" of all else, and where
 * commas are expected in one value. */
const char *cml_number_hint(const char *value, const char *expected);

/* The one grammar of input errors: "FILE:LINE: FIELD = VALUE (expected EXPECTED)"; line <= 0 leaves ":LINE"
 * out, value NULL or "" prints "FIELD is missing". Returns CML_E_INPUT. */
CML_NODISCARD cml_status cml_fail_field(struct cml_error *err, const char *file, int line, const char *field,
                                        const char *value, const char *expected);

/* "out of memory: N MiB for WHAT". Returns CML_E_INPUT, because only a request in the input can ask for that
 * much. */
CML_NODISCARD cml_status cml_fail_memory(struct cml_error *err, double bytes, const char *what);
