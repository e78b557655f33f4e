/* SPDX-License-Identifier: MIT */
#include "input/sweep/sweep_groups.h"

#include <stdlib.h>
#include <string.h>

bool cml_sweep_is_absorption(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot && strcmp(dot, ".mua") == 0;
}

static bool fit_in(const struct cml_sweep_table *table, int column, bool first, const char *a, const char *b)
{
    if (table->label[column] || strcmp(a, b) == 0) return true;
    if (!cml_sweep_is_absorption(table->name[column])) return false;
    return !first || (strtod(a, NULL) > 0) == (strtod(b, NULL) > 0);
}

static bool fit(const struct cml_sweep_table *table, int first, int a, int b)
{
    for (int c = 0; c < table->num_columns; c++)
        if (!fit_in(table, c, c == first, cml_sweep_cell(table, a, c).value,
                    cml_sweep_cell(table, b, c).value))
            return false;
    return true;
}

cml_status cml_sweep_group(const struct cml_sweep_table *table, int first_layer, int **group, int *num_groups,
                           struct cml_error *err)
{
    const size_t rows = (size_t)table->num_rows;
    int *first = calloc(rows, sizeof *first), count = 0; /* row of each group */
    *group = calloc(rows, sizeof **group);
    if (!*group || !first) {
        free(first);
        free(*group);
        *group = NULL;
        return cml_fail_memory(err, 2.0 * (double)(rows * sizeof **group), "the rows");
    }
    for (int row = 0; row < table->num_rows; row++) {
        int number = 0;
        while (number < count && !fit(table, first_layer, first[number], row)) number++;
        if (number == count) first[count++] = row;
        (*group)[row] = number;
    }
    *num_groups = count;
    free(first);
    return CML_OK;
}
