/* SPDX-License-Identifier: MIT */
#include "plot/compare.h"

#include "base/significance.h"
#include "plot/compare_arrays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the files ---- */

/* Fewer packets than batches make no error. */
static bool has_errors(const struct cml_outcome *o)
{
    if (o->photons < CML_COMPARE_BATCHES) return false;
    for (int i = 0; i < CML_TOTALS; i++)
        if (!cml_outcome_errors(o, (enum cml_quantity)i)) return false;
    return true;
}

/* NULL when the file has none. */
static const double *errors_of(const struct cml_outcome *o, enum cml_quantity which)
{
    static const double none = 0;
    if (has_errors(o)) return cml_outcome_errors(o, which);
    return which == CML_QUANTITY_Rsp ? &none : NULL;
}

/* Refuses results whose bins differ: there is nothing to compare bin by bin. Materials may differ: that is
 * often the question. */
static cml_status check_grids(const struct cml_outcome *a, const struct cml_outcome *b,
                              const char *const names[2], struct cml_error *err)
{
    const bool timed = a->num_gates > 0 && b->num_gates > 0, directed = a->nt > 0 && b->nt > 0;
    const struct {
        const char *field;
        double a, b;
    } fields[] = {
        {"dz", a->dz, b->dz},
        {"dr", a->dr, b->dr},
        {"nz", a->nz, b->nz},
        {"nr", a->nr, b->nr},
        {"na", a->na, b->na},
        {"time: T1", timed ? a->time_end : 0, timed ? b->time_end : 0},
        {"time: number of gates", timed ? a->num_gates : 0, timed ? b->num_gates : 0},
        {"directions: NT", directed ? a->nt : 0, directed ? b->nt : 0},
        {"directions: NP", directed ? a->np : 0, directed ? b->np : 0},
    };
    const double printed = 1e-5; /* a length has six digits in the file */
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
        if (fabs(fields[i].a - fields[i].b) > printed * fields[i].a) /* as if the first were right */
            return cml_fail(err, CML_E_INPUT, "%s: %s = %g (expected %g, as in %s)", names[1],
                            fields[i].field, fields[i].b, fields[i].a, names[0]);
    return CML_OK;
}

/* ---- the comparison ---- */

/* No weight of packets that might be taken together with its neighbour's. */
static bool is_alone(enum cml_quantity which)
{
    return cml_compare_comes_of(which, CML_FROM_MEANS) || cml_compare_comes_of(which, CML_FROM_FACETS) ||
           cml_quantity_is_derivative(which);
}

/* Both errors are known, and of a detector's means enough packets. */
static bool can_test_alone(const struct cml_compare_quantity *q, int i, const int part[2])
{
    for (int k = 0; k < 2; k++) {
        const struct cml_outcome *o = q->outcome[k];
        if (!isfinite(q->value[k][i]) || !(q->error[k][i] > 0) ||
            q->packets[k] < CML_COMPARE_BATCHES * CML_COMPARE_PACKETS)
            return false;
        if (!cml_compare_comes_of(q->which, CML_FROM_MEANS)) continue;
        const double *seen = o->value[CML_QUANTITY_detector], *error = o->error[CML_QUANTITY_detector];
        if (!seen || !error || !(seen[part[k]] >= sqrt(CML_COMPARE_PACKETS) * error[part[k]])) return false;
    }
    return true;
}

static void test_alone(const struct cml_compare_quantity *q, const int part[2], struct cml_comparison *c)
{
    struct cml_compare_scan scan = {.tests = 0};
    for (int i = 0; i < q->bins; i++) {
        if (can_test_alone(q, i, part)) cml_compare_one_bin(q, i, &scan, c);
    }
    c->bins[q->which] += scan.tests;
}

static void test_quantity(const struct cml_compare_quantity *q, struct cml_comparison *c)
{
    struct cml_compare_scan scan = {.tests = 0};
    cml_compare_scan_bins(q, q->bins, &scan, c);
    cml_compare_end_scan(q, &scan, c);
}

static bool tallied_absorption(const struct cml_outcome *o)
{
    for (int i = 0; i < o->nz; i++)
        if (o->value[CML_QUANTITY_A_z][i] > 0) return true;
    return !(o->value[CML_QUANTITY_A][0] > 0);
}

bool cml_compare_tests(enum cml_quantity which)
{
    const enum cml_estimator estimator = cml_quantities[which].estimator;
    return cml_quantity_is_total(which) || estimator == CML_FROM_BATCHES || estimator == CML_FROM_ONCE ||
           estimator == CML_FROM_EXPECTED || estimator == CML_FROM_GROUPS || estimator == CML_FROM_LAYERS ||
           estimator == CML_FROM_BODIES || is_alone(which);
}

/* A file without errors has none of these, or means another thing by them. */
static bool needs_errors_of_both(enum cml_quantity which)
{
    return cml_compare_comes_of(which, CML_FROM_GROUPS) || cml_compare_comes_of(which, CML_FROM_LAYERS) ||
           cml_compare_comes_of(which, CML_FROM_BODIES) || is_alone(which);
}

/* By its indices. */
static void set_shape(struct cml_compare_quantity *q)
{
    const int first = cml_quantity_is_of_detector(q->which);
    for (int i = first; i < CML_QUANTITY_AXES && cml_quantities[q->which].axis[i] != CML_AXIS_NONE; i++)
        q->shape[i - first] = cml_outcome_bins(q->outcome[0], cml_quantities[q->which].axis[i]);
}

/* Both results' own part under one name: detectors may stand in another order, or be in one of them alone,
 * and layers be others. */
static void test_part(const struct cml_outcome *const outcome[2], enum cml_quantity which, int part,
                      struct cml_comparison *c)
{
    const size_t size = cml_outcome_part_size(outcome[0], which);
    struct cml_compare_quantity q = {.which = which, .bins = (int)size};
    int parts[2];
    if (cml_outcome_part_size(outcome[1], which) != size) return;
    cml_outcome_key(outcome[0], which, part, q.key);
    for (int k = 0; k < 2; k++) {
        const char *name = cml_quantity_is_of_detector(which) ? outcome[0]->detector[part] : NULL;
        const int own = name ? cml_outcome_find_detector(outcome[k], name, strlen(name)) : 0;
        if (own < 0) return;
        const bool may_lack = is_alone(which) && has_errors(outcome[k]);
        const double *error = may_lack ? outcome[k]->error[which] : errors_of(outcome[k], which);
        parts[k] = own;
        q.outcome[k] = outcome[k];
        q.packets[k] = (double)outcome[k]->photons;
        q.value[k] = outcome[k]->value[which] + (size_t)own * size;
        q.error[k] = error ? error + (size_t)own * size : NULL;
    }
    if (needs_errors_of_both(which) && !(q.error[0] && q.error[1])) return;
    if (is_alone(which)) {
        set_shape(&q);
        test_alone(&q, parts, c);
    } else {
        test_quantity(&q, c);
    }
}

static void test_all(const struct cml_outcome *const outcome[2], struct cml_comparison *c)
{
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        const enum cml_quantity which = (enum cml_quantity)i;
        const bool absorption = which == CML_QUANTITY_A_z || which == CML_QUANTITY_A_rz;
        if (!cml_compare_tests(which) || (absorption && c->no_absorption) || !outcome[0]->value[which] ||
            !outcome[1]->value[which])
            continue;
        for (int part = 0; part < cml_outcome_parts(outcome[0], which); part++)
            test_part(outcome, which, part, c);
    }
}

/* p of the largest |z|, corrected for the number of tests. */
static void conclude(struct cml_comparison *c)
{
    c->worst = -1;
    for (int i = 0; i < c->count; i++)
        if (c->worst < 0 || fabs(c->test[i].z) > fabs(c->test[c->worst].z)) c->worst = i;
    c->p = c->worst < 0 ? 1 : cml_sidak(c->test[c->worst].p, c->tests);
}

/* At most one test per bin and total, so the tests' memory is known beforehand. */
cml_status cml_compare(const struct cml_outcome *a, const struct cml_outcome *b, const char *const names[2],
                       struct cml_comparison *c, struct cml_error *err)
{
    const struct cml_outcome *const outcome[2] = {a, b};
    *c = (struct cml_comparison){.measured = {has_errors(a), has_errors(b)},
                                 .lends = {cml_compare_lends(a), cml_compare_lends(b)},
                                 .no_absorption = !tallied_absorption(a) + 2 * !tallied_absorption(b)};
    CML_TRY(check_grids(a, b, names, err));
    size_t tests = 0;
    for (int i = 0; i < CML_NUM_QUANTITIES; i++)
        if (cml_compare_tests((enum cml_quantity)i)) tests += cml_outcome_size(a, (enum cml_quantity)i);
    c->test = malloc(tests * sizeof *c->test);
    if (!c->test) return cml_fail_memory(err, (double)tests * sizeof *c->test, "the comparison");
    test_all(outcome, c);
    const cml_status status = cml_compare_arrays(outcome, names, c, err);
    conclude(c);
    if (status != CML_OK) cml_comparison_clear(c);
    return status;
}

void cml_comparison_clear(struct cml_comparison *comparison)
{
    free(comparison->test);
    *comparison = (struct cml_comparison){0};
}
