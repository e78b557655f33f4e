/* Words key=value behind the fields of an m or beam line. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"

#define CML_MCI_MAX_KEYS 8

/* The options of one line, handed out one by one. The reader of the line fills the first five members. */
struct cml_mci_line_options {
    struct cml_mci_reader *reader;
    const char *owner;                  /* what the line describes, for messages: "boundary 2", "beam" */
    const char *keys[CML_MCI_MAX_KEYS]; /* NULL behind the last one */
    const char *flag;                   /* the key that may stand alone, without '='; NULL: none */
    const char *list;                   /* the keys in words, for messages */
    bool seen[CML_MCI_MAX_KEYS];
    int key;     /* index of the key read last */
    char *value; /* what stands behind its '=', or the key itself where it stands alone */
    bool alone;
};

/* Goes to the next option of the current line: options->key and options->value, or *more false at the end of
 * the line. CML_E_INPUT for an unknown key and for one that comes twice. */
CML_NODISCARD cml_status cml_mci_next_option(struct cml_mci_line_options *options, bool *more);

/* cml_mci_fail with the field "OWNER: FIELD". */
CML_NODISCARD cml_status cml_mci_fail_option(const struct cml_mci_line_options *options, const char *field,
                                             const char *value, const char *expected);

/* cml_mci_fail_option with the key and the value of the option read last. */
CML_NODISCARD cml_status cml_mci_fail_value(const struct cml_mci_line_options *options, const char *expected);

/* "1,2,3": exactly `count` numbers up to +-CML_MCI_HUGE, with nothing between them but commas. */
bool cml_mci_parse_list(const char *text, int count, double *values);

/* The index of `word` in names[count], -1 when it is none of them. */
int cml_mci_choose(const char *word, const char *const *names, int count);
