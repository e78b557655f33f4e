/* SPDX-License-Identifier: MIT */
#include "plot/compare_report.h"

#include "base/json_name.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WORST_LISTED = 5 };

/* The tests with the largest |z|, largest first; returns how many. */
static int find_worst(const struct cml_comparison *c, const struct cml_compare_test *worst[WORST_LISTED])
{
    int count = 0;
    for (int i = 0; i < c->count; i++) {
        int rank = count;
        while (rank > 0 && fabs(worst[rank - 1]->z) < fabs(c->test[i].z)) rank--;
        if (rank == WORST_LISTED) continue;
        if (count < WORST_LISTED) count++;
        for (int j = count - 1; j > rank; j--) worst[j] = worst[j - 1];
        worst[rank] = &c->test[i];
    }
    return count;
}

/* NULL where the quantity was not tested. */
static const struct cml_compare_test *worst_of(const struct cml_comparison *c, enum cml_quantity quantity)
{
    const struct cml_compare_test *worst = NULL;
    for (int i = 0; i < c->count; i++) {
        if (c->test[i].quantity != quantity) continue;
        if (!worst || fabs(c->test[i].z) > fabs(worst->z)) worst = &c->test[i];
    }
    return worst;
}

/* ---- for people ---- */

/* Where the errors come from decides how much a difference means, so it stands first. */
static void print_file(FILE *stream, const struct cml_compare_report *report, int k)
{
    const struct cml_comparison *c = report->comparison;
    const char *errors = "standard errors from the file";
    if (!c->measured[k] && !c->measured[1 - k])
        errors = "no standard errors: upper bounds";
    else if (!c->measured[k])
        errors = c->lends[1 - k]
                     ? "no standard errors: variances of the other file"
                     : "no standard errors: upper bounds (--sampling random in the other would find more)";
    fprintf(stream, "%c: %s, %.0f packets, %s\n", "ab"[k], report -> names[k],
            (double)report -> outcome[k].photons, errors);
}

/* What explains a difference, or an agreement, without being tested itself. */
static void print_notes(FILE *stream, const struct cml_compare_report *report)
{
    const struct cml_outcome *a = &report->outcome[0], *b = &report->outcome[1];
    if (a->num_streams == 1 && b->num_streams == 1 && a->stream->seed == b->stream->seed &&
        a->stream->run == b->stream->run)
        fprintf(stream,
                "note: both runs have seed %llu: they share their noise, so that agreement says little\n",
                (unsigned long long)a->stream->seed);
    if (a->num_layers != b->num_layers)
        fprintf(stream, "note: %d and %d layers\n", a->num_layers, b->num_layers);
    for (int l = 0; l < a->num_layers && l < b->num_layers; l++)
        for (int i = 0; i < CML_LAYER_NUMBERS; i++) {
            const double one = *cml_outcome_layer(a, l, i), two = *cml_outcome_layer(b, l, i);
            const char *name = cml_quantities[CML_QUANTITY_layer_n + i].name + strlen("layer_");
            if (one != two) fprintf(stream, "note: layer %d: %s = %g and %g\n", l + 1, name, one, two);
        }
    if (report->comparison->left_out[0])
        fprintf(stream, "note: without errors, or with other bins: %s\n", report->comparison->left_out);
}

/* Tests are ordered by quantity, the totals of every run first. */
static void print_totals(FILE *stream, const struct cml_comparison *c)
{
    fprintf(stream, "%-5s %12s %10s %12s %10s %8s\n", "", "a", "error", "b", "error", "z");
    for (int i = 0; i < c->count; i++) {
        const struct cml_compare_test *t = &c->test[i];
        if (!cml_quantity_is_total(t->quantity)) continue;
        fprintf(stream, "%-5s %12.6g %10.2g %12.6g %10.2g %+8.2f\n", cml_quantities[t->quantity].name,
                t->value[0], t->error[0], t->value[1], t->error[1], t->z);
    }
}

/* "[2][0][7]" of the first bin. */
static void print_indices(FILE *stream, const struct cml_compare_test *t)
{
    int index[CML_QUANTITY_AXES] = {0}, left = t->first, axes = 0;
    while (axes < CML_QUANTITY_AXES && t->shape[axes]) axes++;
    for (int i = axes - 1; i >= 0; left /= t->shape[i--]) index[i] = left % t->shape[i];
    fputs(t->key, stream);
    for (int i = 0; i < axes; i++) fprintf(stream, "[%d]", index[i]);
    if (t->last > t->first) fprintf(stream, " and %d more", t->last - t->first);
}

/* "r [cm] 0.12..0.13"; "layer 2" */
static void print_bin(FILE *stream, const struct cml_compare_test *t)
{
    if (t->shape[0]) {
        print_indices(stream, t);
        return;
    }
    const char *axis = cml_quantity_axes(t->quantity);
    if (cml_quantity_is_of_detector(t->quantity)) fprintf(stream, "%s ", t->key);
    if (axis && t->upper > t->lower)
        fprintf(stream, "%s %.4g..%.4g", axis, t->lower, t->upper);
    else if (axis)
        fprintf(stream, t->last > t->first ? "%s %d..%d" : "%s %d", axis, t->first + 1, t->last + 1);
}

/* Of A_z as of the others. */
static const char *why_not_tested(const struct cml_comparison *c, enum cml_quantity quantity)
{
    static const char *const untallied[] = {"too few packets", "a did not tally it", "b did not tally it",
                                            "neither run tallied it"};
    return untallied[quantity == CML_QUANTITY_A_z ? c->no_absorption : 0];
}

/* One line per profile, also for those that could not be tested: silence would look like agreement. */
static void print_profiles(FILE *stream, const struct cml_comparison *c)
{
    for (int q = CML_TOTALS; q < CML_NUM_QUANTITIES; q++) {
        const enum cml_quantity quantity = (enum cml_quantity)q;
        const struct cml_compare_test *worst = worst_of(c, quantity);
        const bool of_mcml = quantity >= CML_QUANTITY_A_z && quantity <= CML_QUANTITY_Tt_a;
        if (cml_quantity_is_total(quantity) || (!worst && !of_mcml)) continue;
        fprintf(stream, "%-5s ", cml_quantities[q].name);
        if (!worst) {
            fprintf(stream, "not tested: %s\n", why_not_tested(c, quantity));
            continue;
        }
        fprintf(stream, "%d bins in %d tests, worst z %+.2f at ", c->bins[q], c->tests_of[q], worst->z);
        print_bin(stream, worst);
        fputc('\n', stream);
    }
}

/* Of all quantities together, because the p-value below is that of the first of them. */
static void print_worst(FILE *stream, const struct cml_comparison *c)
{
    const struct cml_compare_test *worst[WORST_LISTED];
    const int count = find_worst(c, worst);
    fputs("worst:\n", stream);
    for (int i = 0; i < count; i++) {
        const struct cml_compare_test *t = worst[i];
        fprintf(stream, "  z %+6.2f  p %-8.2g  %-4s %11.5g +- %-8.2g %11.5g +- %-8.2g %-5s ", t->z, t->p,
                t->key, t->value[0], t->error[0], t->value[1], t->error[1], cml_quantity_unit(t->quantity));
        print_bin(stream, t);
        fputc('\n', stream);
    }
}

/* From what is known to what follows from it: files, totals, profiles, the worst, the verdict. */
void cml_compare_summary(FILE *stream, const struct cml_compare_report *report)
{
    const struct cml_comparison *c = report->comparison;
    for (int k = 0; k < 2; k++) print_file(stream, report, k);
    print_notes(stream, report);
    print_totals(stream, c);
    print_profiles(stream, c);
    print_worst(stream, c);
    fprintf(stream, "p = %.3g (Sidak over %d tests): %s at the level %g\n", c->p, c->tests,
            c->p < report->alpha ? "they differ" : "no difference", report->alpha);
}

/* ---- for programs ---- */

/* JSON knows no infinity: a difference without any noise. */
static double without_infinity(double z)
{
    return fmin(fmax(z, -1e300), 1e300);
}

/* Values in the unit of the file, ends of the bins on the axis in cm or rad. */
static json_t *test_json(const struct cml_compare_test *t)
{
    return json_pack("{s:s, s:i, s:i, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:s}", "quantity", t->key,
                     "first", t->first, "last", t->last, "lower", t->lower, "upper", t->upper, "a",
                     t->value[0], "a_se", t->error[0], "b", t->value[1], "b_se", t->error[1], "z",
                     without_infinity(t->z), "p", t->p, "unit", cml_quantity_unit(t->quantity));
}

/* z of all tests of a quantity, and the bins with which they begin. */
static void add_deviates(json_t *object, const struct cml_comparison *c, int quantity)
{
    json_t *first = json_array(), *z = json_array();
    for (int i = 0; i < c->count; i++) {
        if ((int)c->test[i].quantity != quantity) continue;
        json_array_append_new(first, json_integer(c->test[i].first));
        json_array_append_new(z, json_real(without_infinity(c->test[i].z)));
    }
    json_object_set_new(object, "first", first);
    json_object_set_new(object, "z", z);
}

/* All quantities of an outcome have an entry, so that readers need not ask whether one is there; `worst` is
 * null where there was no test. */
static json_t *quantities_json(const struct cml_comparison *c)
{
    json_t *object = json_object();
    for (int q = 0; q < CML_NUM_QUANTITIES; q++) {
        if (!cml_compare_tests((enum cml_quantity)q) && c->tests_of[q] == 0) continue;
        const struct cml_compare_test *worst = worst_of(c, (enum cml_quantity)q);
        json_t *entry = json_pack("{s:i, s:i, s:o}", "bins", c->bins[q], "tests", c->tests_of[q], "worst",
                                  worst ? test_json(worst) : json_null());
        add_deviates(entry, c, q);
        json_object_set_new(object, cml_quantities[q].name, entry);
    }
    return object;
}

static json_t *worst_json(const struct cml_comparison *c)
{
    const struct cml_compare_test *worst[WORST_LISTED];
    const int count = find_worst(c, worst);
    json_t *list = json_array();
    for (int i = 0; i < count; i++) json_array_append_new(list, test_json(worst[i]));
    return list;
}

cml_status cml_compare_json(FILE *stream, const struct cml_compare_report *report, struct cml_error *err)
{
    const struct cml_comparison *c = report->comparison;
    json_t *object = json_pack(
        "{s:o, s:o, s:[I, I], s:i, s:f, s:f, s:b, s:o, s:o}", "a", cml_json_name(report->names[0]), "b",
        cml_json_name(report->names[1]), "packets", (json_int_t)report->outcome[0].photons,
        (json_int_t)report->outcome[1].photons, "tests", c->tests, "p", c->p, "alpha", report->alpha, "agree",
        !(c->p < report->alpha), "quantities", quantities_json(c), "worst", worst_json(c));
    return cml_json_print(stream, object, err);
}
