/* Reading of text: files line by line, words, and strict numbers. Knows no file format. Numbers are read in
 * the "C" locale, since the program never calls setlocale. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* A whole file in memory, read line by line. The caller owns it and frees it with cml_text_clear. */
struct cml_text {
    char *path;    /* path as given; "standard input" for "-" */
    char *data;    /* [size] bytes and a final NUL */
    size_t size;   /* size of data in bytes */
    size_t cursor; /* offset of the first byte that cml_text_next has not returned */
    int line;      /* number of the line returned last, from 1 */
};

/* Largest size of a table file in bytes. The whole table is in memory, beside the numbers read from it. */
#define CML_MOST_TABLE ((size_t)256 << 20)

/* A source of files. `read` sets *data to the *size bytes of a file and a final NUL; the caller frees *data,
 * also after a failure, when it may be NULL. A file of more than `most` bytes is refused. A NULL source means
 * cml_text_read_file. */
struct cml_text_source {
    cml_status (*read)(void *context, const char *path, size_t most, char **data, size_t *size,
                       struct cml_error *err);
    void *context;
};

/* Reads the text file `path` ("-" is standard input) from `source`; NULL means the file system. Returns
 * CML_E_INPUT if the file cannot be opened or read, holds a NUL byte, or is a directory: "PATH: cannot be
 * read: REASON (expected ...)". On failure *text is cleared. */
CML_NODISCARD cml_status cml_text_read(const struct cml_text_source *source, const char *path,
                                       struct cml_text *text, struct cml_error *err);

/* Reads a table file as cml_text_read does, but refuses more than CML_MOST_TABLE bytes. */
CML_NODISCARD cml_status cml_text_read_table(const struct cml_text_source *source, const char *path,
                                             struct cml_text *text, struct cml_error *err);

/* Reads a binary file as cml_text_read does, but accepts NUL bytes. */
CML_NODISCARD cml_status cml_text_read_bytes(const struct cml_text_source *source, const char *path,
                                             struct cml_text *text, struct cml_error *err);

/* Reads a file, or standard input for "-", of at most `most` bytes. Sets *data to its *size bytes and a final
 * NUL; the caller frees *data. */
CML_NODISCARD cml_status cml_text_read_file(const char *path, size_t most, char **data, size_t *size,
                                            struct cml_error *err);

/* Frees the file's memory and zeroes the structure. */
void cml_text_clear(struct cml_text *text);

/* Returns the name of a path for messages: "standard input" for "-". */
const char *cml_text_name(const char *path);

/* True if the file name ends in `extension`. Case is ignored, because files come from systems that write
 * capitals. */
bool cml_file_ends_in(const char *path, const char *extension);

/* Returns the next line without its line end (LF or CRLF; the last line needs none); NULL at the end of the
 * file. The line is NUL-terminated in place, and the caller may change it until cml_text_clear. */
char *cml_text_next(struct cml_text *text);

/* Cuts the next word, a run of non-blanks, out of *cursor: NUL-terminates it in place and moves *cursor
 * behind it. Returns NULL if only blanks are left. A word that begins with '"' runs to the closing '"' and
 * loses both quotes. Without a closing quote it keeps its opening quote, so that the caller's check refuses
 * it. A word key="..." also runs to the closing '"', and keeps both quotes. */
char *cml_text_word(char **cursor);

/* Returns the index of a word among words with blanks between them; -1: it is none of them. */
int cml_word_index(const char *words, const char *word);

/* Parses a word that is one number as a whole, in decimal or exponent form: sets *value and returns true.
 * Returns false for anything else, for hexadecimal numbers, nan and inf, and on overflow. */
bool cml_parse_double(const char *word, double *value);

/* Parses a word that is a whole number from 0 to 2^53, also written like 1e7 or 2.5e3: sets *value and
 * returns true; else returns false. */
bool cml_parse_count(const char *word, uint64_t *value);

/* Parses a word of decimal digits with an optional sign, in the range of int: sets *value and returns true;
 * else returns false. */
bool cml_parse_int(const char *word, int *value);

/* Copies a string, which the caller frees. Returns CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_text_copy(const char *text, char **copy, struct cml_error *err);

/* Prints a format into a new string, which the caller frees; NULL on failure. what: name of the string, for
 * the message. */
CML_NODISCARD CML_PRINTF(4, 5) cml_status
    cml_text_format(char **text, const char *what, struct cml_error *err, const char *format, ...);

/* Prints a short text for one argument of a call, as in CML_TEXT("layer %d", l). The text lives as long as
 * the block around the call. Bytes beyond CML_TEXT_SIZE are cut off. */
#define CML_TEXT_SIZE 400
#define CML_TEXT(...) cml_text_short((char[CML_TEXT_SIZE]){""}, __VA_ARGS__)
CML_PRINTF(2, 3) const char *cml_text_short(char text[CML_TEXT_SIZE], const char *format, ...);

/* Closes a stream of open_memstream, which has set *text and *size. `out` may be NULL if open_memstream
 * failed. Fails only if memory runs out, and then sets *text to NULL. */
CML_NODISCARD cml_status cml_text_end(FILE *out, char **text, const size_t *size, const char *what,
                                      struct cml_error *err);

/* Prints each line of a text behind the prefix, with a line feed at its end. A NULL text prints nothing. */
void cml_text_print(FILE *out, const char *prefix, const char *text);

/* Joins the directory of the path `beside` with `name`, unless `name` is absolute: the path of a file that is
 * named inside the file `beside`. The caller frees *path. */
CML_NODISCARD cml_status cml_path_beside(const char *beside, const char *name, char **path,
                                         struct cml_error *err);

/* ---- guessing which known name an unknown word means ---- */

/* The best guess so far. Zero all members except word and length before the first name is offered. */
struct cml_guess {
    const char *word; /* [length] letters of the unknown word */
    size_t length;
    const char *nearest;
    size_t distance;      /* letters to change, add or leave out to get from the word to `nearest` */
    const char *complete; /* a name that begins with the word */
    int completions;      /* number of names that begin with the word */
};

/* Compares one more name with the word. Words and names of more than 63 letters match nothing. */
void cml_guess_offer(struct cml_guess *guess, const char *name);

/* Returns the only name that begins with the word. Otherwise returns the nearest name, ignoring case, if at
 * most two letters are wrong (one for a word of three letters) and at most half of the name's letters; else
 * NULL. */
const char *cml_guess_best(const struct cml_guess *guess);
