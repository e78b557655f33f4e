/* Words key=value behind the numbers of a line. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"

/* A line whose options are read. Its reader fills the first five members. */
struct cml_mci_line {
    struct cml_mci_reader *reader;
    const char *owner;                /* what the line describes, for messages: "boundary 2", "beam" */
    const struct cml_key_part *parts; /* whose keys the line may have */
    cml_status (*own)(
        struct cml_mci_line *line); /* reads the value of a key of type CML_KEY_OWN; NULL: none */
    void *context;                  /* of `own` */
    const struct cml_key *key;      /* read last */
    char *value;                    /* what stands behind its '=', or the key itself where it stands alone */
    bool alone;
    struct {
        const char *name, *value;
    } seen[12]; /* all that were read */
    int num_seen;
};

/* Reads all options up to the end of the line. CML_E_INPUT for an unknown key, for one that comes twice, and
 * for a value that is not in the key's range. */
CML_NODISCARD cml_status cml_mci_options(struct cml_mci_line *line);

/* The text of an option of that name; NULL: none was read. */
const char *cml_mci_saw(const struct cml_mci_line *line, const char *name);

/* cml_mci_fail with the field "OWNER: FIELD". */
CML_NODISCARD cml_status cml_mci_fail_option(const struct cml_mci_line *line, const char *field,
                                             const char *value, const char *expected);

/* cml_mci_fail_option with the key and the value of the option read last. */
CML_NODISCARD cml_status cml_mci_fail_value(const struct cml_mci_line *line, const char *expected);

/* "1,2,3": exactly `count` numbers up to +-CML_MCI_HUGE, with nothing between them but commas. */
bool cml_mci_parse_list(const char *text, int count, double *values);

/* The index of `word` in names[count], -1 when it is none of them. */
int cml_mci_choose(const char *word, const char *const *names, int count);
