/* Piece by piece. SPDX-License-Identifier: MIT */
#include "plot/compare_arrays.h"

#include "base/text.h"
#include "output/files/hdf5_arrays.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Numbers that are read at a time. */
enum { PIECE = 2048 };

/* An array of both files, and its errors. */
struct both {
    const struct cml_hdf5_arrays *file; /* [2] */
    struct cml_hdf5_array *value[2], *error[2];
};

/* ---- which ---- */

/* The end of an array's name: before it stands what it is of, a boundary or a detector. */
static void ending_of(enum cml_quantity quantity, char ending[CML_OUTCOME_KEY])
{
    const char *name = cml_quantities[quantity].name, *facet = strstr(name, "_facet");
    if (quantity == CML_QUANTITY_detector_map)
        strcpy(ending, "_map");
    else if (facet)
        snprintf(ending, CML_OUTCOME_KEY, "_%.*s", (int)(facet - name), name);
    else
        strcpy(ending, name);
}

static bool find_quantity(const char *name, enum cml_quantity *quantity)
{
    const bool of_detector = strncmp(name, "detector_", strlen("detector_")) == 0;
    char ending[CML_OUTCOME_KEY];
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        *quantity = (enum cml_quantity)i;
        if (!cml_compare_is_of_files(*quantity) || cml_quantity_is_of_detector(*quantity) != of_detector)
            continue;
        ending_of(*quantity, ending);
        const size_t length = strlen(ending), size = strlen(name);
        if (length <= size && strcmp(name + size - length, ending) == 0) return true;
    }
    return false;
}

/* Places are equal but for their digits. */
static bool same_axis(const struct cml_axis *one, const struct cml_axis *other)
{
    if (one->n != other->n) return false;
    const double width = one->n > 0 ? fabs(one->values[one->n - 1]) + fabs(one->values[0]) : 0;
    for (size_t i = 0; i < one->n; i++)
        if (!(fabs(one->values[i] - other->values[i]) <= 1e-5 * width)) return false;
    return true;
}

static bool same_axes(const struct cml_field *one, const struct cml_field *other)
{
    if (one->num_axes != other->num_axes || one->num_axes > CML_QUANTITY_AXES) return false;
    for (int i = 0; i < one->num_axes; i++)
        if (!same_axis(one->axis[i], other->axis[i])) return false;
    return cml_field_size(one) <= INT_MAX;
}

/* All of the four have the same bins. */
static bool can_test(struct both *both, const char *name)
{
    char errors[72];
    snprintf(errors, sizeof errors, "%s_se", name);
    for (int k = 0; k < 2; k++) {
        both->error[k] = cml_hdf5_arrays_find(&both->file[k], errors);
        if (!both->error[k] || !same_axes(&both->value[0]->field, &both->value[k]->field) ||
            !same_axes(&both->value[0]->field, &both->error[k]->field))
            return false;
    }
    return true;
}

static void leave_out(struct cml_comparison *c, const char *name)
{
    const size_t length = strlen(c->left_out);
    snprintf(c->left_out + length, sizeof c->left_out - length, "%s%s", length > 0 ? ", " : "", name);
}

/* ---- values ---- */

static cml_status read_numbers(const struct cml_hdf5_arrays *file, struct cml_hdf5_array *array, size_t begin,
                               size_t count, double *out, struct cml_error *err)
{
    CML_TRY(cml_hdf5_array_read(file, array, begin, count, out, err));
    for (size_t i = 0; i < count; i++)
        if (!isfinite(out[i]))
            return cml_fail(err, CML_E_INPUT, "%.400s: %s[%zu] = %g (expected a finite number)",
                            file->file.path, array->field.name, begin + i, out[i]);
    return CML_OK;
}

static cml_status scan_array(const struct both *both, struct cml_compare_quantity *q,
                             struct cml_comparison *c, struct cml_error *err)
{
    struct cml_compare_scan scan = {.tests = 0};
    double value[2][PIECE], error[2][PIECE];
    for (q->begin = 0; q->begin < q->bins; q->begin += PIECE) {
        const int left = q->bins - q->begin, count = left < PIECE ? left : PIECE;
        for (int k = 0; k < 2; k++) {
            CML_TRY(
                read_numbers(&both->file[k], both->value[k], (size_t)q->begin, (size_t)count, value[k], err));
            CML_TRY(
                read_numbers(&both->file[k], both->error[k], (size_t)q->begin, (size_t)count, error[k], err));
            q->value[k] = value[k];
            q->error[k] = error[k];
        }
        cml_compare_scan_bins(q, q->begin + count, &scan, c);
    }
    cml_compare_end_scan(q, &scan, c);
    return CML_OK;
}

/* An array of the first file, where the other has it, too. */
static cml_status test_array(const struct cml_hdf5_arrays file[2], struct cml_hdf5_array *first,
                             const struct cml_outcome *const outcome[2], struct cml_comparison *c,
                             struct cml_error *err)
{
    const struct cml_field *field = &first->field;
    struct both both = {.file = file, .value = {first, cml_hdf5_arrays_find(&file[1], field->name)}};
    struct cml_compare_quantity q = {.outcome = {outcome[0], outcome[1]},
                                     .packets = {(double)outcome[0]->photons, (double)outcome[1]->photons}};
    if (!both.value[1] || field->num_axes == 0 || !find_quantity(field->name, &q.which)) return CML_OK;
    if (!can_test(&both, field->name)) {
        leave_out(c, field->name);
        return CML_OK;
    }
    snprintf(q.key, sizeof q.key, "%s", field->name);
    q.bins = (int)cml_field_size(field);
    for (int i = 0; i < field->num_axes; i++) q.shape[i] = (int)field->axis[i]->n;
    return scan_array(&both, &q, c, err);
}

static cml_status test_files(const struct cml_hdf5_arrays file[2], const struct cml_outcome *const outcome[2],
                             struct cml_comparison *c, struct cml_error *err)
{
    const size_t room = (size_t)c->count + (size_t)file[0].count + 1;
    struct cml_compare_test *test = realloc(c->test, room * sizeof *test);
    if (!test) return cml_fail_memory(err, (double)room * sizeof *test, "the comparison");
    c->test = test;
    for (int i = 0; i < file[0].count; i++) CML_TRY(test_array(file, &file[0].item[i], outcome, c, err));
    return CML_OK;
}

cml_status cml_compare_arrays(const struct cml_outcome *const outcome[2], const char *const names[2],
                              struct cml_comparison *c, struct cml_error *err)
{
    struct cml_hdf5_arrays file[2];
    for (int k = 0; k < 2; k++)
        if (!cml_file_ends_in(names[k], ".h5") || !c->measured[k]) return CML_OK;
    CML_TRY(cml_hdf5_arrays_open(names[0], &file[0], err));
    cml_status status = cml_hdf5_arrays_open(names[1], &file[1], err);
    if (status == CML_OK) {
        status = test_files(file, outcome, c, err);
        cml_hdf5_arrays_close(&file[1]);
    }
    cml_hdf5_arrays_close(&file[0]);
    return status;
}
