/* Reader of the table of --sweep: names in the first line, one run in every other line. Commas separate the
 * cells. Blanks around cells, blank lines and text behind # are ignored. A cell may stand in quotation marks,
 * in which "" is one mark; a column whose name is quoted is a label, which is carried along. mci_settings.h
 * knows the meaning and the range of the other names, and which of them are labels, too.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/settings.h"
#include "base/text.h"

/* A table of --sweep. A struct of zeros is no table. */
struct cml_sweep_table {
    struct cml_text text; /* text that the cells point into */
    int num_columns, num_rows;
    int names_line;                 /* line of the names in the file, from 1 */
    char (*name)[CML_SETTING_NAME]; /* [num_columns] names of the columns */
    bool *label;                    /* [num_columns] true: a label, carried along and not set */
    char **cell;                    /* [num_rows][num_columns], none empty */
    int *line;                      /* [num_rows] line of each row in the file, from 1 */
};

/* Reads `path` from `source` (NULL: the file system). The caller clears *table. CML_E_INPUT with file, line
 * and column: *table is cleared. */
CML_NODISCARD cml_status cml_sweep_table_read(const struct cml_text_source *source, const char *path,
                                              struct cml_sweep_table *table, struct cml_error *err);
void cml_sweep_table_clear(struct cml_sweep_table *table);

/* Returns a cell as a setting, which points into the table. */
struct cml_setting cml_sweep_cell(const struct cml_sweep_table *table, int row, int column);
