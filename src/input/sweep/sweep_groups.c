/* SPDX-License-Identifier: MIT */
#include "input/sweep/sweep_groups.h"

#include <stdlib.h>
#include <string.h>

bool cml_sweep_is_absorption(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot && strcmp(dot, ".mua") == 0;
}

/* Returns mus [1/cm] that a medium has in a row of the table. */
static double scattering(const struct cml_sweep_table *table, int row, const struct cml_sweep_medium *medium)
{
    const int column = medium->scattering;
    return column < 0 ? medium->mus : strtod(cml_sweep_cell(table, row, column).value, NULL);
}

/* True if the cells of one column allow rows a and b to share a flight. */
static bool may_share_in(const struct cml_sweep_table *table, int column,
                         const struct cml_sweep_medium *medium, int a, int b)
{
    const char *cell_a = cml_sweep_cell(table, a, column).value,
               *cell_b = cml_sweep_cell(table, b, column).value;
    if (table->label[column] || strcmp(cell_a, cell_b) == 0) return true;
    if (!cml_sweep_is_absorption(table->name[column])) return false;
    if ((strtod(cell_a, NULL) > 0) == (strtod(cell_b, NULL) > 0)) return true;
    return !medium->is_first_layer && scattering(table, a, medium) > 0;
}

/* True if rows a and b of a sweep may share a flight: they differ only in absorption that reweighting can
 * make up for. */
static bool may_share(const struct cml_sweep_table *table, const struct cml_sweep_medium *media, int a, int b)
{
    for (int c = 0; c < table->num_columns; c++)
        if (!may_share_in(table, c, &media[c], a, b)) return false;
    return true;
}

/* A row joins the first group whose first row it may share a flight with. */
cml_status cml_sweep_group(const struct cml_sweep_table *table, const struct cml_sweep_medium *media,
                           int **group, int *num_groups, struct cml_error *err)
{
    const size_t rows = (size_t)table->num_rows;
    CML_FREED int *first = NULL; /* first row of each group */
    int count = 0;
    CML_TRY(cml_zeros(&first, rows, sizeof *first, "the rows", err));
    CML_TRY(cml_zeros(group, rows, sizeof **group, "the rows", err));
    for (int row = 0; row < table->num_rows; row++) {
        int number = 0;
        while (number < count && !may_share(table, media, first[number], row)) number++;
        if (number == count) first[count++] = row;
        (*group)[row] = number;
    }
    *num_groups = count;
    return CML_OK;
}
