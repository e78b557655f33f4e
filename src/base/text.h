/* Text in: the line reader and strict numbers. Knows nothing of any format.
 * Numbers are read in the "C" locale (the program never calls setlocale).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* A whole file in memory, handed out line by line. Owned by the caller; free with cml_text_clear. */
struct cml_text {
    char *path;    /* as given; "standard input" for "-" */
    char *data;    /* size bytes and a final NUL */
    size_t size;   /* bytes read */
    size_t cursor; /* first byte that cml_text_next has not handed out */
    int line;      /* number of the line handed out last, from 1 */
};

/* Bytes that a table may have: all of it is in memory, beside what is made of it. */
#define CML_MOST_TABLE ((size_t)256 << 20)

/* Where files come from. `read` makes *data the *size bytes of a file and a final NUL; also after a failure
 * it is NULL or the caller's to free. A file of more than `most` bytes is refused. A NULL pointer to a source
 * stands for cml_text_read_file. */
struct cml_text_source {
    cml_status (*read)(void *context, const char *path, size_t most, char **data, size_t *size,
                       struct cml_error *err);
    void *context;
};

/* Reads `path` ("-" is standard input) from `source`, NULL: the file system. CML_E_INPUT when it cannot be
 * opened or read, holds a NUL byte, or is a directory: "PATH: cannot be read: REASON (expected ...)". On
 * failure *text is cleared. */
CML_NODISCARD cml_status cml_text_read(const struct cml_text_source *source, const char *path,
                                       struct cml_text *text, struct cml_error *err);

/* cml_text_read for a table: one of more than CML_MOST_TABLE bytes is refused with its size. */
CML_NODISCARD cml_status cml_text_read_table(const struct cml_text_source *source, const char *path,
                                             struct cml_text *text, struct cml_error *err);

/* cml_text_read for a file that is not text: NUL bytes are data. */
CML_NODISCARD cml_status cml_text_read_bytes(const struct cml_text_source *source, const char *path,
                                             struct cml_text *text, struct cml_error *err);

/* A whole file of the file system, or standard input, of at most `most` bytes: *size bytes and a final NUL,
 * the caller's to free. */
CML_NODISCARD cml_status cml_text_read_file(const char *path, size_t most, char **data, size_t *size,
                                            struct cml_error *err);

void cml_text_clear(struct cml_text *text);

/* A path as messages name it: "standard input" for "-". */
const char *cml_text_name(const char *path);

/* Whether the name of a file ends so, in small letters or capitals, for files come from other systems. */
bool cml_file_ends_in(const char *path, const char *extension);

/* The next line without its line end (LF or CRLF; the last line needs none); NULL at the end of the file.
 * The line is NUL-terminated in place and may be changed by the caller until cml_text_clear. */
char *cml_text_next(struct cml_text *text);

/* Cuts the next word (a run of non-blanks) out of *cursor: NUL-terminates it in place and moves *cursor
 * behind it. Returns NULL when only blanks are left. A word that begins with '"' runs to the closing '"' and
 * loses both; when the closing one is missing the word is returned with its opening '"', so that the caller's
 * check refuses it. A word key="..." runs to the closing '"', too, and keeps both. */
char *cml_text_word(char **cursor);

/* Whole-word conversions: true, and *value set, only when the entire word is one number.
 * cml_parse_double takes decimal and exponent forms only: no hexadecimal, no nan, no inf, nothing that
 * overflows. cml_parse_count takes 0 <= n <= 2^53, also written like 1e7 or 2.5e3 (must be whole).
 * cml_parse_int takes decimal digits with an optional sign in the range of int. */
bool cml_parse_double(const char *word, double *value);
bool cml_parse_count(const char *word, uint64_t *value);
bool cml_parse_int(const char *word, int *value);

/* strdup that reports through err. */
CML_NODISCARD cml_status cml_text_copy(const char *text, char **copy, struct cml_error *err);

/* What printf makes of the format, the caller's to free; NULL on failure. `what` that is, for the message. */
CML_NODISCARD CML_PRINTF(4, 5) cml_status
    cml_text_format(char **text, const char *what, struct cml_error *err, const char *format, ...);

/* Ends a stream in memory, *text and *size of open_memstream; out NULL: it could not be begun. It fails only
 * where memory runs out: then *text is NULL. */
CML_NODISCARD cml_status cml_text_end(FILE *out, char **text, const size_t *size, const char *what,
                                      struct cml_error *err);

/* The lines of a text, each behind the prefix and ended by a line feed. text NULL: none. */
void cml_text_print(FILE *out, const char *prefix, const char *text);

/* Joins the directory of `beside` with `name`, unless name is absolute: how a file named inside another is
 * found. */
CML_NODISCARD cml_status cml_path_beside(const char *beside, const char *name, char **path,
                                         struct cml_error *err);

/* ---- which of some names was probably meant by a word that is none of them ---- */

/* The best name so far; zero before the first one is offered. */
struct cml_guess {
    const char *word; /* [length] */
    size_t length;
    const char *nearest;
    size_t distance;      /* of that: letters to be changed, added or left out */
    const char *complete; /* a name that begins with the word */
    int completions;      /* how many do */
};

/* Looks at one more name. Words and names of more than 63 letters are like none. */
void cml_guess_offer(struct cml_guess *guess, const char *name);

/* The only name that begins with the word; else the nearest one, if at most two letters of more than three,
 * or one of three, and at most half of its own, are wrong; else NULL. Capitals are not wrong. */
const char *cml_guess_best(const struct cml_guess *guess);
