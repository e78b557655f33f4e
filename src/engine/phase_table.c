/* Makes tables of phase functions, cell by cell: a straight line if it is accurate enough, else a straight
 * line for each part of the cell. The probability of a part equals the allowed error, so parts are accurate
 * enough whatever the function does in them.
 * SPDX-License-Identifier: MIT */
#include "engine/phase_table.h"

#include "types.h"

#include <math.h>
#include <stdlib.h>

#define CELLS ((int)CML_PHASE_CELLS)
#define PARTS ((int)CML_PHASE_PARTS)

/* A phase function while its table is made. */
struct source {
    const struct cml_phase *phase;
    bool mirrored;
};

/* Returns the share of light that is deflected by less than `deflection` (1 - cosine). If the function is
 * mirrored, `deflection` is measured from the backward direction (1 + cosine). */
static double share_below(const struct source *source, double deflection)
{
    if (!source->mirrored) return cml_phase_below(source->phase, deflection);
    return 1 - cml_phase_below(source->phase, 2 - deflection);
}

/* Returns the deflection of a share, the inverse of share_below: the upper one of two neighbouring numbers
 * between which the share lies. Each step cuts the bracket at a chord, a little to either side of it, so that
 * both ends close in. Every fourth step halves the bracket. */
static double deflection_of(const struct source *source, double share, double low, double high)
{
    double lacks = share_below(source, low) - share, exceeds = share_below(source, high) - share;
    for (int i = 0; low < high; i++) {
        const double width = high - low, middle = low + width / 2;
        if (middle == low || middle == high) break;
        double x = low - lacks * width / (exceeds - lacks) + (i % 2 ? width : -width) / 1024;
        if (i % 4 == 3 || !(x > low && x < high)) x = middle;
        const double excess = share_below(source, x) - share;
        if (excess < 0) {
            low = x;
            lacks = excess;
        } else {
            high = x;
            exceeds = excess;
        }
    }
    return high;
}

/* Returns the mean deflection over a cell, by Gauss and Legendre's rule with three nodes. low, high: bracket
 * of the cell's deflections. */
static double mean_of(const struct source *source, int cell, double low, double high)
{
    static const double node[] = {0.11270166537925831, 0.5, 0.88729833462074169},
                        weight[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    double sum = 0;
    for (int i = 0; i < 3; i++) sum += weight[i] * deflection_of(source, (cell + node[i]) / CELLS, low, high);
    return sum;
}

/* Returns the line with the cell's mean deflection. Its errors cancel in all moments up to terms of third
 * order in the cell's width. In the first and last cell it ends where the deflection does. */
static struct cml_phase_line line_of(const struct source *source, int cell, double low, double high)
{
    const double mean = mean_of(source, cell, low, high);
    if (cell == 0) return (struct cml_phase_line){low, 2 * (mean - low)};
    if (cell == CELLS - 1) return (struct cml_phase_line){2 * mean - high, 2 * (high - mean)};
    return (struct cml_phase_line){mean - (high - low) / 2, high - low};
}

/* True if the line's distribution function is right to one part of the cell, at seventeen places along the
 * line. */
static bool is_accurate(const struct source *source, int cell, struct cml_phase_line line)
{
    enum { PLACES = 16 };
    for (int i = 0; i <= PLACES; i++) {
        const double y = (double)i / PLACES, x = fmin(fmax(line.start + line.slope * y, 0), 2);
        if (!(fabs(share_below(source, x) * CELLS - cell - y) < 1.0 / PARTS)) return false;
    }
    return line.slope >= 0 && line.start >= 0;
}

/* Makes room for the parts of one more cell. A full array doubles. */
static cml_status grow(struct cml_phase_tables *tables, size_t *capacity, struct cml_error *err)
{
    if (tables->count + CML_PHASE_PARTS <= *capacity) return CML_OK;
    const size_t bytes = 2 * *capacity * sizeof *tables->item;
    struct cml_phase_line *larger = realloc(tables->item, bytes);
    if (!larger) return cml_fail_memory(err, (double)bytes, "phase functions");
    tables->item = larger;
    *capacity *= 2;
    return CML_OK;
}

/* Appends the parts of a cell. Each part is a straight line between two points of the exact curve, as a
 * function of the y of the whole cell. */
static void add_parts(const struct source *source, int cell, double low, double high,
                      struct cml_phase_tables *tables)
{
    double before = low;
    for (int i = 0; i < PARTS; i++) {
        const double share = (cell + (i + 1.0) / PARTS) / CELLS;
        const double next = i == PARTS - 1 ? high : deflection_of(source, share, before, high);
        const double slope = PARTS * (next - before);
        tables->item[tables->count++] = (struct cml_phase_line){before - slope * i / PARTS, slope};
        before = next;
    }
}

/* Fills the table of one phase function, from which packets draw the deflection. Cell k covers an equal
 * share of probability, with a straight line through it. A cell in which the line is too inaccurate refers
 * to CML_PHASE_PARTS smaller parts behind all tables. */
static cml_status fill(const char *file, const struct cml_phase *phase, struct cml_phase_tables *tables,
                       size_t *capacity, struct cml_error *err)
{
    const struct source source = {phase, cml_phase_mean(phase) < 0};
    const size_t first = (size_t)phase->index * CML_PHASE_CELLS;
    double low = 0;
    for (int k = 0; k < CELLS; k++) {
        const double high = k == CELLS - 1 ? 2 : deflection_of(&source, (k + 1.0) / CELLS, low, 2);
        struct cml_phase_line line = line_of(&source, k, low, high);
        if (!is_accurate(&source, k, line)) {
            if (tables->count + CML_PHASE_PARTS > CML_MOST_PHASE_CELLS)
                return cml_fail_field(err, file, phase->line, "phase", cml_phase_name(phase->kind),
                                      "smoother or fewer functions: their tables have more than 2^24 cells");
            CML_TRY(grow(tables, capacity, err));
            line = (struct cml_phase_line){-(double)tables->count, -1};
            add_parts(&source, k, low, high, tables);
        }
        tables->item[first + (size_t)k] = line;
        low = high;
    }
    return CML_OK;
}

/* The memory begins with twice the cells of all undivided tables, and grows with the parts of divided cells.
 * */
cml_status cml_phase_tables_create(const char *file, const struct cml_phase *phases,
                                   struct cml_phase_tables *tables, struct cml_error *err)
{
    size_t capacity = 2 * CML_PHASE_CELLS * (size_t)(phases->index + 1);
    *tables = (struct cml_phase_tables){calloc(capacity, sizeof *tables->item), capacity / 2};
    if (!tables->item)
        return cml_fail_memory(err, (double)(capacity * sizeof *tables->item), "phase functions");
    for (const struct cml_phase *phase = phases; phase; phase = phase->next) {
        const cml_status status = fill(file, phase, tables, &capacity, err);
        if (status == CML_OK) continue;
        free(tables->item);
        return status;
    }
    return CML_OK;
}
