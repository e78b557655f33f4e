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
    char text[1024]; /* the message; print it by cml_print_line, since it may quote any text from users */
};

#define CML_NODISCARD __attribute__((warn_unused_result))
#define CML_PRINTF(fmt, args) __attribute__((format(printf, fmt, args)))

/* Returns from the calling function with the status of `call` unless it is CML_OK. */
#define CML_TRY(call)                                                                                        \
    do {                                                                                                     \
        const cml_status cml_try_status_ = (call);                                                           \
        if (cml_try_status_ != CML_OK) return cml_try_status_;                                               \
    } while (0)

/* Declares that a local variable owns a resource. At the end of the variable's scope, on every way out,
 * CML_FREED frees the resource and CML_AT_END calls `end` with the variable's address. The variable must be
 * initialised where it is declared, empty or with its resource. */
#define CML_AT_END(end) __attribute__((cleanup(end), unused))
#define CML_FREED CML_AT_END(cml_free_owned)

/* Frees the memory to which the pointer at `variable` points (CML_FREED). */
static inline void cml_free_owned(void *variable)
{
    void *owned;
    memcpy(&owned, variable, sizeof owned);
    free(owned);
}

/* Makes an array of `count` elements of `size` bytes, all zero. `array` is the address of the pointer to it,
 * for the caller to free. count may be 0. CML_E_INPUT if memory for `what` runs out; the pointer is NULL
 * then. */
CML_NODISCARD cml_status cml_zeros(void *array, size_t count, size_t size, const char *what,
                                   struct cml_error *err);

/* Writes the message to `err` and returns `status`. A message longer than err->text loses its middle. */
CML_NODISCARD CML_PRINTF(3, 4) cml_status
    cml_fail(struct cml_error *err, cml_status status, const char *format, ...);

/* Returns a hint for a number in another notation: ", with a decimal point" for "0,5", ", without commas" for
 * "1,000", ", without ;" for "1.4;". Returns "" for any other value, and if `expected` itself has commas
 * inside a value. */
const char *cml_number_hint(const char *value, const char *expected);

/* Writes an input error in the only form that input errors have: "FILE:LINE: FIELD = VALUE (expected
 * EXPECTED)". line <= 0 leaves ":LINE" out; value NULL or "" prints "FIELD is missing". Returns
 * CML_E_INPUT. */
CML_NODISCARD cml_status cml_fail_field(struct cml_error *err, const char *file, int line, const char *field,
                                        const char *value, const char *expected);

/* Writes "out of memory: N MiB for WHAT". Returns CML_E_INPUT, because only a request in the input can need
 * that much memory. */
CML_NODISCARD cml_status cml_fail_memory(struct cml_error *err, double bytes, const char *what);
