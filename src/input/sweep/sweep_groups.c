/* SPDX-License-Identifier: MIT */
#include "input/sweep/sweep_groups.h"

#include <stdlib.h>
#include <string.h>

bool cml_sweep_is_absorption(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot && strcmp(dot, ".mua") == 0;
}

/* What scatters in the medium of a column of absorption, in a row: `mus` where the table does not say. */
static double scattering(const struct cml_sweep_table *table, int row, int column, double mus)
{
    const char *name = table->name[column];
    const size_t owner = strlen(name) - strlen("mua");
    for (int c = 0; c < table->num_columns; c++)
        if (!table->label[c] && strncmp(table->name[c], name, owner) == 0 &&
            strcmp(table->name[c] + owner, "mus") == 0)
            return strtod(cml_sweep_cell(table, row, c).value, NULL);
    return mus;
}

static bool fit_in(const struct cml_sweep_table *table, int column, double mus, int a, int b)
{
    const char *name = table->name[column], *cell_a = cml_sweep_cell(table, a, column).value,
               *cell_b = cml_sweep_cell(table, b, column).value;
    if (table->label[column] || strcmp(cell_a, cell_b) == 0) return true;
    if (!cml_sweep_is_absorption(name)) return false;
    if ((strtod(cell_a, NULL) > 0) == (strtod(cell_b, NULL) > 0)) return true;
    return strcmp(name, "layer1.mua") != 0 && scattering(table, a, column, mus) > 0;
}

static bool fit(const struct cml_sweep_table *table, const double *mus, int a, int b)
{
    for (int c = 0; c < table->num_columns; c++)
        if (!fit_in(table, c, mus[c], a, b)) return false;
    return true;
}

cml_status cml_sweep_group(const struct cml_sweep_table *table, const double *mus, int **group,
                           int *num_groups, struct cml_error *err)
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
        while (number < count && !fit(table, mus, first[number], row)) number++;
        if (number == count) first[count++] = row;
        (*group)[row] = number;
    }
    *num_groups = count;
    free(first);
    return CML_OK;
}
