/* Lines and numbers of .mci files, for mci.c (the grammar) and the files mci_*.c (keyword lines). Hands out
 * the data lines of original MCML and the keyword lines that it does not know, reads the fields of a line
 * against their ranges, and keeps the lines of a run as written. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "base/text.h"
#include "input/input_options.h"
#include "input/keys/key.h"

/* A file being read line by line. */
struct cml_mci_reader {
    const struct cml_input_options *options;
    struct cml_text text;
    struct cml_error *err;
    char *cursor; /* rest of the current line */
    char *kept;   /* the lines read since cml_mci_forget, joined with line feeds */
    size_t kept_size, kept_capacity;
    size_t kept_last; /* offset of the current line in `kept` */
};

/* The kind of a line: its keyword, or one of the last three. */
enum cml_mci_kind {
    CML_MCI_B,
    CML_MCI_M,
    CML_MCI_ROUGH,
    CML_MCI_FACE,
    CML_MCI_PORT,
    CML_MCI_I,
    CML_MCI_PHASE,
    CML_MCI_BACKING,
    CML_MCI_BEAM, /* from here on keyword lines that concern the whole run, not one boundary */
    CML_MCI_MAP,
    CML_MCI_FACETS,
    CML_MCI_TIME,
    CML_MCI_DIRECTIONS,
    CML_MCI_FLUENCE,
    CML_MCI_DETECTOR,
    CML_MCI_PHOTONS,
    CML_MCI_DATA,
    CML_MCI_UNKNOWN, /* "#@ " and then no keyword */
    CML_MCI_END      /* the end of the file */
};
#define CML_MCI_KEYWORDS CML_MCI_DATA

/* A keyword, and where its lines may stand, in words for messages. */
struct cml_mci_keyword {
    const char *word, *place;
    /* Beginnings of the text behind the keyword, by which a comment is told from a keyword line that lost its
     * mark: words, 0 for a number, " for a file name, $ for the end of the line. */
    const char *looks;
};
extern const struct cml_mci_keyword cml_mci_keywords[CML_MCI_KEYWORDS];

/* Reads the file `path`; the reader stands before its first line. `options` and `err` must outlive the
 * reader. Close it with cml_mci_close, also after a failure. */
CML_NODISCARD cml_status cml_mci_open(const char *path, const struct cml_input_options *options,
                                      struct cml_mci_reader *reader, struct cml_error *err);
void cml_mci_close(struct cml_mci_reader *reader);

/* Goes to the next line that is neither blank nor a comment. keywords: true if keywords count without "#@ "
 * before them, too (the name of an output may be "b"). The cursor then stands behind the keyword, or at the
 * start of a data line. */
CML_NODISCARD cml_status cml_mci_next(struct cml_mci_reader *reader, bool keywords, enum cml_mci_kind *kind);

/* Returns the keyword that the first word of a data line may have been meant for; NULL: none, or the word is
 * a number. */
const char *cml_mci_meant_keyword(const struct cml_mci_reader *reader);

/* Returns the place in a line where a word begins with `key`; NULL: no such word. */
char *cml_mci_find_word(char *line, const char *key);

/* Returns the current line as written, valid until the next call of cml_mci_next. */
const char *cml_mci_raw(const struct cml_mci_reader *reader);

/* Forgets the kept lines: a run begins with the next line. */
void cml_mci_forget(struct cml_mci_reader *reader);

/* Hands the kept lines over to the caller, who frees them. */
char *cml_mci_take_kept(struct cml_mci_reader *reader);

/* Ends a text at the first '#' outside quotes. A number may touch the '#' ("0.1#dz"), as in MCML. */
void cml_mci_cut_comment(char *text);

/* Fails like cml_fail_field, with the file and number of the current line. */
CML_NODISCARD cml_status cml_mci_fail(const struct cml_mci_reader *reader, const char *field,
                                      const char *value, const char *expected);

/* Adds the current line to the message about a file that the line names, because the mistake may be in the
 * line: "FILE:LINE: OWNER: " before a message that begins with the name of `file`. Returns `status`. */
CML_NODISCARD cml_status cml_mci_name_line(const struct cml_mci_reader *reader, const char *owner,
                                           const char *file, cml_status status);

/* Sends a note about a line to the user: "FILE:LINE: TEXT". */
CML_PRINTF(3, 4) void cml_mci_note(const struct cml_mci_reader *reader, int line, const char *format, ...);

/* Refuses a word as the value of a key: "OWNER: KEY = WORD (expected RANGE)". owner NULL: "OWNER: " is left
 * out. word NULL: the value is missing. */
CML_NODISCARD cml_status cml_mci_fail_key(const struct cml_mci_reader *reader, const char *owner,
                                          const struct cml_key *key, const char *word);

/* Reads the next word of the line as the number of `key` into the struct at `base`. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_number(struct cml_mci_reader *reader, const char *owner,
                                        const struct cml_key *key, void *base);

/* Reads the numbers that have a fixed place in the line, for all parts in order. The rest of the line is the
 * caller's to read. */
CML_NODISCARD cml_status cml_mci_leading_numbers(struct cml_mci_reader *reader, const char *owner,
                                                 const struct cml_key_part *parts);

/* Reads a data line that has only these numbers. Text behind them is a comment, but a further number or a
 * unit other than cm or 1/cm is an error. */
CML_NODISCARD cml_status cml_mci_numbers(struct cml_mci_reader *reader, const char *owner,
                                         const struct cml_key_part *parts);

/* Reads the table in the file `name`, which lies beside the scene. owner: the keyword of the line that names
 * the file. read: reads all rows, each of which begins at the cursor. CML_E_INPUT with `expected` if name is
 * NULL or no name. */
CML_NODISCARD cml_status cml_mci_table(struct cml_mci_reader *reader, const char *owner, const char *name,
                                       const char *expected,
                                       cml_status (*read)(struct cml_mci_reader *rows, void *context),
                                       void *context);

/* Goes to the next row that is neither blank nor a comment; false at the end. */
bool cml_mci_next_row(struct cml_mci_reader *rows);

/* Refuses a word where the line should end; a comment is allowed. */
CML_NODISCARD cml_status cml_mci_end_line(struct cml_mci_reader *reader, const char *owner);

/* Returns the rule that a name of an output breaks, as text for "expected ..."; NULL: the name is good. */
const char *cml_mci_why_no_name(const char *name);
