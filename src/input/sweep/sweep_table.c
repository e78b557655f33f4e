/* SPDX-License-Identifier: MIT */
#include "input/sweep/sweep_table.h"

#include "base/array.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_ROWS = 1000000 };
static const char blanks[] = " \t\r";

/* Returns the text without the blanks around it; cuts its end. */
static char *trim(char *text)
{
    text += strspn(text, blanks);
    size_t length = strlen(text);
    while (length > 0 && strchr(blanks, text[length - 1])) text[--length] = '\0';
    return text;
}

/* Returns the place where a comment begins (a # outside quotation marks), or the end of the line. */
static char *find_comment(char *line)
{
    bool quoted = false;
    for (; *line && (quoted || *line != '#'); line++) quoted ^= *line == '"';
    return line;
}

/* Returns the next line that is not empty; NULL: none. */
static char *next_line(struct cml_text *text)
{
    for (char *line; (line = cml_text_next(text));) {
        *find_comment(line) = '\0';
        line = trim(line);
        if (*line) return line;
    }
    return NULL;
}

struct cell {
    char *text;
    bool quoted;
    char *behind; /* text behind the closing quotation mark, "" in a good cell; NULL: the mark is missing */
};

/* Takes the quotation marks off a cell and returns the text behind them. Returns NULL and leaves the cell
 * unchanged if the closing mark is missing. */
static char *unquote(char *cell)
{
    char *end = cell + 1, *to = cell;
    for (; *end && (*end != '"' || end[1] == '"'); end += *end == '"' ? 2 : 1) {
    }
    if (!*end) return NULL;
    for (const char *from = cell + 1; from < end; from += *from == '"' ? 2 : 1) *to++ = *from;
    *to = '\0';
    return end + 1;
}

/* Cuts the next cell off a line of the table and moves *line behind the comma. A cell may be in quotation
 * marks, inside which commas do not count. False behind the last cell. */
static bool next_cell(char **line, struct cell *cell)
{
    if (!*line) return false;
    char *text = *line + strspn(*line, blanks);
    const bool quoted = *text == '"';
    char *behind = quoted ? unquote(text) : NULL;
    char *comma = strchr(behind ? behind : text, ',');
    *line = comma ? comma + 1 : NULL;
    if (comma) *comma = '\0';
    *cell = (struct cell){quoted ? text : trim(text), quoted, behind ? trim(behind) : NULL};
    return true;
}

/* Refuses something in the current line of the sweep's table. */
static cml_status fail_at(const struct cml_text *text, const char *field, const char *value,
                          const char *expected, struct cml_error *err)
{
    return cml_fail_field(err, text->path, text->line, field, value, expected);
}

/* Refuses a quoted cell without its closing mark, or with text behind it. */
static cml_status check_quotes(const struct cml_sweep_table *table, const struct cell *cell, int column,
                               struct cml_error *err)
{
    if (!cell->quoted || (cell->behind && !*cell->behind)) return CML_OK;
    return fail_at(&table->text, CML_TEXT("column %d", column + 1), cell->behind ? cell->behind : cell->text,
                   cell->behind ? "a comma behind the closing quotation mark"
                                : "a closing quotation mark in the line",
                   err);
}

/* Adds a column with the name in a cell. A name in quotation marks is a label, any other name is a
 * setting. */
static cml_status read_name(struct cml_sweep_table *table, const struct cell *cell, struct cml_error *err)
{
    const char *name = cell->text;
    const int column = table->num_columns;
    const char *field = CML_TEXT("column %d", column + 1);
    CML_TRY(check_quotes(table, cell, column, err));
    if (*name == '\0' || strlen(name) >= sizeof *table->name)
        return fail_at(&table->text, field, name,
                       cell->quoted ? "a label of at most 63 bytes" : "a name like layer1.mua", err);
    if (!cell->quoted && strchr(name, ';'))
        return fail_at(&table->text, field, name, "one name; commas part the columns", err);
    if (!cell->quoted && strpbrk(name, " \t"))
        return fail_at(&table->text, field, name,
                       "one name; commas part the columns, and labels stand in quotation marks", err);
    for (int i = 0; i < column; i++)
        if (strcmp(table->name[i], name) == 0)
            return fail_at(&table->text, field, name, "a name that no other column has", err);
    table->label[column] = cell->quoted;
    strcpy(table->name[table->num_columns++], name);
    return CML_OK;
}

/* Refuses a table of labels only: programs that quote every text would make one. */
static cml_status check_labels(const struct cml_sweep_table *table, struct cml_error *err)
{
    for (int i = 0; i < table->num_columns; i++)
        if (!table->label[i]) return CML_OK;
    return fail_at(&table->text, "column 1", table->name[0],
                   "a name without quotation marks, which is set: those in quotation marks are labels", err);
}

/* Reads the first line of the table of a sweep: the names of the columns. */
static cml_status read_header(struct cml_sweep_table *table, struct cml_error *err)
{
    char *line = next_line(&table->text);
    if (!line) return fail_at(&table->text, "the line of names", NULL, "layer1.mua, photons or others", err);
    table->names_line = table->text.line;
    CML_TRY(cml_zeros(&table->name, CML_MOST_SETTINGS, sizeof *table->name, "a table", err));
    CML_TRY(cml_zeros(&table->label, CML_MOST_SETTINGS, sizeof *table->label, "a table", err));
    for (struct cell cell; next_cell(&line, &cell);) {
        if (table->num_columns == CML_MOST_SETTINGS)
            return fail_at(&table->text, "columns", cell.text, "at most 256", err);
        CML_TRY(read_name(table, &cell, err));
    }
    return check_labels(table, err);
}

/* Adds a row with the cells of a line. Every column needs a value. Cells point into the text of the table. */
static cml_status read_row(struct cml_sweep_table *table, char *line, struct cml_error *err)
{
    int cells = 0;
    if (table->num_rows == MOST_ROWS) return fail_at(&table->text, "rows", "more", "at most 1000000", err);
    const size_t rows = (size_t)table->num_rows, columns = (size_t)table->num_columns;
    CML_TRY(cml_array_grow(&table->cell, rows, columns * sizeof *table->cell, "a table", err));
    CML_TRY(cml_array_grow(&table->line, rows, sizeof *table->line, "a table", err));
    const int row = table->num_rows++;
    table->line[row] = table->text.line;
    for (struct cell cell; next_cell(&line, &cell); cells++) {
        CML_TRY(check_quotes(table, &cell, cells, err));
        if (cells >= table->num_columns) continue;
        table->cell[(size_t)row * (size_t)table->num_columns + (size_t)cells] = cell.text;
        if (*cell.text) continue;
        return fail_at(&table->text, CML_TEXT("column %d, %s", cells + 1, table->name[cells]), NULL,
                       "a value", err);
    }
    if (cells == table->num_columns) return CML_OK;
    return fail_at(&table->text, "number of cells", CML_TEXT("%d", cells),
                   CML_TEXT("%d, as many as names%s", table->num_columns,
                            cells > table->num_columns ? "; commas part cells, decimals have a point" : ""),
                   err);
}

/* Reads the names of columns and all rows of a sweep. */
static cml_status read_table(struct cml_sweep_table *table, struct cml_error *err)
{
    CML_TRY(read_header(table, err));
    for (char *line; (line = next_line(&table->text));) CML_TRY(read_row(table, line, err));
    if (table->num_rows > 0) return CML_OK;
    return fail_at(&table->text, "the first row", NULL, "a value for every name", err);
}

cml_status cml_sweep_table_read(const struct cml_text_source *source, const char *path,
                                struct cml_sweep_table *table, struct cml_error *err)
{
    *table = (struct cml_sweep_table){0};
    CML_TRY(cml_text_read_table(source, path, &table->text, err));
    const cml_status status = read_table(table, err);
    if (status != CML_OK) cml_sweep_table_clear(table);
    return status;
}

void cml_sweep_table_clear(struct cml_sweep_table *table)
{
    cml_text_clear(&table->text);
    free(table->name);
    free(table->label);
    free(table->cell);
    free(table->line);
    *table = (struct cml_sweep_table){0};
}

struct cml_setting cml_sweep_cell(const struct cml_sweep_table *table, int row, int column)
{
    struct cml_setting setting = {
        .value = table->cell[(size_t)row * (size_t)table->num_columns + (size_t)column],
        .source = table->text.path,
        .line = table->line[row],
        .column = column + 1,
    };
    strcpy(setting.name, table->name[column]);
    return setting;
}
