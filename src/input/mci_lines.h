/* Lines and numbers of .mci files: what mci.c (grammar) and the files mci_*.c of our own lines stand on.
 * Hands out data lines, tells the lines that original MCML does not know, reads the fields of a line against
 * their allowed ranges, and keeps the run's lines as written. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "base/text.h"
#include "input/input_options.h"
#include "input/keys/key.h"

/* A file that is being read, line by line. */
struct cml_mci_reader {
    const struct cml_input_options *options;
    struct cml_text text;
    struct cml_error *err;
    char *cursor; /* what is left of the current line */
    char *kept;   /* the lines handed out since cml_mci_forget, joined with line feeds */
    size_t kept_size, kept_capacity;
    size_t kept_last; /* where in `kept` the current line begins */
};

/* What a line is. */
enum cml_mci_kind {
    CML_MCI_B,
    CML_MCI_M,
    CML_MCI_ROUGH,
    CML_MCI_I,
    CML_MCI_PHASE,
    CML_MCI_BACKING,
    CML_MCI_BEAM, /* from here on lines that hold for the whole run, not for one boundary */
    CML_MCI_MAP,
    CML_MCI_FACETS,
    CML_MCI_TIME,
    CML_MCI_DIRECTIONS,
    CML_MCI_FLUENCE,
    CML_MCI_DETECTOR,
    CML_MCI_PHOTONS,
    CML_MCI_DATA,
    CML_MCI_UNKNOWN, /* "#@ " and then none of the above */
    CML_MCI_END      /* of the file */
};
#define CML_MCI_KEYWORDS CML_MCI_DATA

/* The keyword of a line of ours, and where such a line stands, in words. */
struct cml_mci_keyword {
    const char *word, *place;
    const char *looks; /* how the text behind it begins, by which a comment is told from such a line that lost
                        * its mark: words, 0 for a number, $ for the end of the line */
};
extern const struct cml_mci_keyword cml_mci_keywords[CML_MCI_KEYWORDS];

/* Reads the file and stands before its first line. `options` and `err` must outlive the reader; close it with
 * cml_mci_close, also after a failure. */
CML_NODISCARD cml_status cml_mci_open(const char *path, const struct cml_input_options *options,
                                      struct cml_mci_reader *reader, struct cml_error *err);
void cml_mci_close(struct cml_mci_reader *reader);

/* Goes to the next line that is neither blank nor comment. `keywords`: keywords also count without "#@ "
 * before them (an output may be named "b"). The cursor stands behind the keyword, or at the start of a data
 * line. */
CML_NODISCARD cml_status cml_mci_next(struct cml_mci_reader *reader, bool keywords, enum cml_mci_kind *kind);

/* The keyword that the first word of a data line may have been meant for; NULL: none, or it is a number. */
const char *cml_mci_meant_keyword(const struct cml_mci_reader *reader);

/* Where a word of its own begins with `key` in a line; NULL: nowhere. */
char *cml_mci_find_word(char *line, const char *key);

/* The current line as written. Valid until the next call of cml_mci_next. */
const char *cml_mci_raw(const struct cml_mci_reader *reader);

/* Starts the memory of lines anew: a run begins with the next line. */
void cml_mci_forget(struct cml_mci_reader *reader);

/* Hands the lines kept to the caller, who frees them. */
char *cml_mci_take_kept(struct cml_mci_reader *reader);

/* Ends the text at the first '#' outside quotes. A number may be glued to it ("0.1#dz"), as in MCML. */
void cml_mci_cut_comment(char *text);

/* cml_fail_field at the current line. */
CML_NODISCARD cml_status cml_mci_fail(const struct cml_mci_reader *reader, const char *field,
                                      const char *value, const char *expected);

/* What is wrong with a file that the current line names is said with that line, as the mistake may be there:
 * "FILE:LINE: OWNER: " before a message that begins with the name of `file`. Returns `status`. */
CML_NODISCARD cml_status cml_mci_name_line(const struct cml_mci_reader *reader, const char *owner,
                                           const char *file, cml_status status);

/* Tells the reader's user something of a line: "FILE:LINE: TEXT". */
CML_PRINTF(3, 4) void cml_mci_note(const struct cml_mci_reader *reader, int line, const char *format, ...);

/* Refuses a word, NULL where there is none, in the place of a key: "OWNER: KEY = WORD (expected RANGE)". No
 * owner where that is NULL. */
CML_NODISCARD cml_status cml_mci_fail_key(const struct cml_mci_reader *reader, const char *owner,
                                          const struct cml_key *key, const char *word);

/* Reads the line's next word into a number's place in the struct. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_number(struct cml_mci_reader *reader, const char *owner,
                                        const struct cml_key *key, void *base);

/* Reads the placed numbers of all parts, one after the other; the caller reads what follows them. */
CML_NODISCARD cml_status cml_mci_leading_numbers(struct cml_mci_reader *reader, const char *owner,
                                                 const struct cml_key_part *parts);

/* Reads a data line of nothing but these numbers. Text behind them is a comment, but a number too many, and a
 * unit of another size, are errors. */
CML_NODISCARD cml_status cml_mci_numbers(struct cml_mci_reader *reader, const char *owner,
                                         const struct cml_key_part *parts);

/* Reads a table, the file `name` beside the scene, which a line of `owner` names: `read` takes its rows, each
 * of which begins at the cursor. NULL, or no name: CML_E_INPUT with `expected`. */
CML_NODISCARD cml_status cml_mci_table(struct cml_mci_reader *reader, const char *owner, const char *name,
                                       const char *expected,
                                       cml_status (*read)(struct cml_mci_reader *rows, void *context),
                                       void *context);

/* Goes to the next row that is neither blank nor comment; false: there is none. */
bool cml_mci_next_row(struct cml_mci_reader *rows);

/* Refuses a word where the line should end, but for a comment. */
CML_NODISCARD cml_status cml_mci_end_line(struct cml_mci_reader *reader, const char *owner);

/* What the name of an output was expected to be that is none; NULL: it is one. */
const char *cml_mci_why_no_name(const char *name);
