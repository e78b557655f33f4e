/* Helpers of all fuzzers: conditions that end the process, inputs as files, inputs of several files.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* libFuzzer calls this function with one input after the other. It always returns 0. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Ends the process if an input breaks the condition; libFuzzer keeps that input. */
#define FUZZ_CHECK(condition)                                                                                \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            fprintf(stderr, "%s:%d: %s does not hold\n", __FILE__, __LINE__, #condition);                    \
            abort();                                                                                         \
        }                                                                                                    \
    } while (0)

/* Checks a refusal: it has a status of its own and one line for the user. */
static inline void fuzz_refused(cml_status status, const struct cml_error *err)
{
    FUZZ_CHECK(status != CML_OK && err->text[0] != '\0' && strchr(err->text, '\n') == NULL);
}

/* Returns the path of a file in memory that holds the bytes. The path serves until the next call. */
static inline const char *fuzz_file(const uint8_t *data, size_t size)
{
    static char path[64];
    static int file = -1;
    if (file < 0) {
        file = memfd_create("input", MFD_CLOEXEC);
        FUZZ_CHECK(file >= 0);
        snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    }
    FUZZ_CHECK(ftruncate(file, 0) == 0);
    FUZZ_CHECK(pwrite(file, data, size, 0) == (ssize_t)size);
    return path;
}

/* Returns the path for a writer's output, in a folder that run.sh makes and removes, or in /tmp. Every
 * process has its own. */
static inline const char *fuzz_output(void)
{
    static char path[256];
    const char *folder = getenv("FUZZ_FOLDER");
    if (!path[0]) snprintf(path, sizeof path, "%s/fuzz_%ld", folder ? folder : "/tmp", (long)getpid());
    return path;
}

/* Returns a stream that discards pictures and reports. */
static inline FILE *fuzz_nowhere(void)
{
    static FILE *stream;
    if (!stream) stream = fopen("/dev/null", "w");
    FUZZ_CHECK(stream != NULL);
    return stream;
}

/* Separates the files of an input. The first file is the scene. The others stand for the files that it
 * names, in the order in which they are read; the last one is used again and again. */
#define FUZZ_CUT "\n%%%%\n"

struct fuzz_files {
    const uint8_t *data;
    size_t size; /* bytes not read yet */
};

/* Reads the next file of the input in place of `path`. No input is as long as the limit `most`. */
static inline cml_status fuzz_read(void *context, const char *path, size_t most, char **data, size_t *size,
                                   struct cml_error *err)
{
    (void)most;
    struct fuzz_files *files = context;
    const size_t cut = sizeof FUZZ_CUT - 1;
    const uint8_t *mark = files->size ? memmem(files->data, files->size, FUZZ_CUT, cut) : NULL;
    *size = mark ? (size_t)(mark - files->data) : files->size;
    *data = malloc(*size + 1);
    if (!*data) return cml_fail_memory(err, (double)*size, path);
    if (*size > 0) memcpy(*data, files->data, *size);
    (*data)[*size] = '\0';
    if (mark) {
        files->data += *size + cut;
        files->size -= *size + cut;
    }
    return CML_OK;
}

static inline struct cml_text_source fuzz_source(struct fuzz_files *files)
{
    const struct cml_text_source source = {fuzz_read, files};
    return source;
}
