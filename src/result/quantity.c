/* SPDX-License-Identifier: MIT */
#include "result/quantity.h"

#include "tally/result.h"

#include <stdio.h>
#include <string.h>

/* Words of the table that stand for axes and places. */
#define NUMBER                                                                                               \
    {                                                                                                        \
        CML_AXIS_NONE                                                                                        \
    }
#define OVER1(a)                                                                                             \
    {                                                                                                        \
        CML_AXIS_##a                                                                                         \
    }
#define OVER2(a, b)                                                                                          \
    {                                                                                                        \
        CML_AXIS_##a, CML_AXIS_##b                                                                           \
    }
#define OVER3(a, b, c)                                                                                       \
    {                                                                                                        \
        CML_AXIS_##a, CML_AXIS_##b, CML_AXIS_##c                                                             \
    }
enum { H5 = CML_IN_H5, JSON = CML_IN_JSON };

#define ROW(name, units, estimator, sums, axes, where, long_name)                                            \
    {#name, units, long_name, CML_FROM_##estimator, sums, axes, where},
#define ROW_OF_ARRAY(name, first, second, spread, when, term, estimator, units, axes, where, long_name)      \
    {#name, units, long_name, CML_FROM_##estimator, CML_ARRAY_##name, axes, where},
const struct cml_quantity_info cml_quantities[CML_NUM_QUANTITIES] = {CML_QUANTITIES(ROW, ROW_OF_ARRAY)};

_Static_assert((int)CML_TOTALS == (int)CML_TOTAL_BACKING && CML_TOTALS + 2 == (int)CML_NUM_TOTALS,
               "a row for every total");
_Static_assert((int)CML_QUANTITY_Tt == (int)CML_TOTAL_TRANSMITTED, "totals first, in their order");
_Static_assert((int)CML_BOOKS == (int)CML_BALANCE_BACKING, "a row for every term of every run");
_Static_assert(CML_QUANTITY_book_above - CML_QUANTITY_book_launched == CML_BOOKS - 1, "terms are neighbours");

static const struct {
    const char *name, *long_name, *units;
} axes[CML_NUM_AXES] = {
#define AXIS(name, long_name, units) {#name, long_name, units},
    {"", "", ""}, CML_AXES(AXIS)};

struct cml_axis cml_quantity_axis(enum cml_axis_kind kind, size_t n, double first, double step)
{
    return (struct cml_axis){axes[kind].name, axes[kind].long_name, axes[kind].units, n, first, step, NULL};
}

/* True if a name has this ending. */
static bool ends_in(const char *name, const char *ending)
{
    const size_t length = strlen(name), size = strlen(ending);
    return length >= size && strcmp(name + length - size, ending) == 0;
}

/* Returns the ending of a name if it is one that results of detectors have, such as "_t" or "_se"; NULL
 * otherwise. A detector with such a name would make result names ambiguous. */
const char *cml_quantity_ending(const char *name)
{
    /* Endings of fields: gates, errors, axes of pixels, pixels outside. */
    static const char *const fields[] = {"_later", "_se", "_x", "_y", "_outside"};
    const size_t prefix = strlen(cml_quantities[CML_QUANTITY_detector].name);
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        const char *ending = cml_quantities[i].name + prefix;
        if (i != CML_QUANTITY_detector && cml_quantity_is_of_detector((enum cml_quantity)i) &&
            ends_in(name, ending))
            return ending;
    }
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
        if (ends_in(name, fields[i])) return fields[i];
    return NULL;
}

void cml_quantity_name(struct cml_field *field, enum cml_quantity quantity)
{
    snprintf(field->name, sizeof field->name, "%s", cml_quantities[quantity].name);
    field->long_name = cml_quantities[quantity].long_name;
    field->units = cml_quantities[quantity].units;
}

void cml_quantity_name_errors(struct cml_field *errors, struct cml_field *of)
{
    snprintf(errors->name, sizeof errors->name, "%.50s_se", of->name);
    errors->long_name = "standard error";
    errors->units = of->units;
    memcpy(errors->axis, of->axis, sizeof of->axis);
    errors->num_axes = of->num_axes;
    of->errors = errors->name;
}

enum cml_quantity cml_quantity_of_total(int total)
{
    if (total < CML_TOTALS) return (enum cml_quantity)total;
    return total == (int)CML_TOTAL_BACKING ? CML_QUANTITY_A_backing : CML_QUANTITY_A_face;
}
