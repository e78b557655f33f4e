/* The table of --sweep: names in the first line, one run in every other. Commas part the cells; blanks around
 * them, blank lines and what stands behind # do not count. Cells may stand in quotation marks, in which "" is
 * one: names that do are labels, which are carried along. What the other names mean, whether one of them is
 * a label without marks, and which values they may have, the reader of scenes knows (mci_settings.h).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/settings.h"
#include "base/text.h"

/* Zeroed: no table. */
struct cml_sweep_table {
    struct cml_text text; /* what the cells point into */
    int num_columns, num_rows;
    int names_line;                 /* of the file, from 1 */
    char (*name)[CML_SETTING_NAME]; /* [num_columns] */
    bool *label;                    /* [num_columns] carried along, not set */
    char **cell;                    /* [num_rows][num_columns] none empty */
    int *line;                      /* [num_rows] of the file, from 1 */
};

/* Reads `path` from `source` (NULL: the file system). CML_E_INPUT with file, line and column; then *table is
 * cleared. The caller clears it otherwise. */
CML_NODISCARD cml_status cml_sweep_table_read(const struct cml_text_source *source, const char *path,
                                              struct cml_sweep_table *table, struct cml_error *err);
void cml_sweep_table_clear(struct cml_sweep_table *table);

/* A cell as a setting, which borrows from the table. */
struct cml_setting cml_sweep_cell(const struct cml_sweep_table *table, int row, int column);
