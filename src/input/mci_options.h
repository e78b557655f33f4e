/* Reader of the options of a keyword line: words key=value behind its numbers. SPDX-License-Identifier: MIT
 */
#pragma once

#include "input/mci_lines.h"

/* A line whose options are read. The caller sets the first five members. */
struct cml_mci_line {
    struct cml_mci_reader *reader;
    /* the thing that the line describes, for messages: "boundary 2", "beam" */
    const char *owner;
    const struct cml_key_part *parts; /* groups of keys that the line may have */
    /* Reads the value of a key of type CML_KEY_OWN; NULL: the line has no such keys. */
    cml_status (*own)(struct cml_mci_line *line);
    void *context;             /* context for `own` */
    const struct cml_key *key; /* key of the option read last */
    char *value;               /* text behind its '=', or the key itself where it stands alone */
    bool alone;
    struct {
        const char *name, *value;
    } seen[12]; /* all options read so far */
    int num_seen;
};

/* Reads all options up to the end of the line. CML_E_INPUT: an unknown key, a key that comes twice, or a
 * value outside the key's range. */
CML_NODISCARD cml_status cml_mci_options(struct cml_mci_line *line);

/* Returns the value of the option `name`; NULL: the line does not have it. */
const char *cml_mci_saw(const struct cml_mci_line *line, const char *name);

/* Fails like cml_mci_fail, with the field "OWNER: FIELD". */
CML_NODISCARD cml_status cml_mci_fail_option(const struct cml_mci_line *line, const char *field,
                                             const char *value, const char *expected);

/* Fails like cml_mci_fail_option, with key and value of the option read last. */
CML_NODISCARD cml_status cml_mci_fail_value(const struct cml_mci_line *line, const char *expected);

/* Reads exactly `count` numbers up to +-CML_MCI_HUGE, separated by commas only: "1,2,3". */
bool cml_mci_parse_list(const char *text, int count, double *values);

/* Reads the value of the option `name` of a detector or a port: *name, which the caller frees. CML_E_INPUT.
 */
CML_NODISCARD cml_status cml_mci_take_name(const struct cml_mci_line *line, char **name);

/* Reads the next word of a line `beam port NAME` or `detector port NAME`: *name, which the caller frees.
 * CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_take_port(const struct cml_mci_line *line, char **name);

/* Returns the index of `word` in names[count], or -1. */
int cml_mci_choose(const char *word, const char *const *names, int count);
