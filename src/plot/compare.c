/* SPDX-License-Identifier: MIT */
#include "plot/compare.h"

#include "base/significance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BATCHES = 64 };

/* One quantity of both files, in weight per launched packet. */
struct quantity {
    enum cml_quantity which;
    char key[CML_OUTCOME_KEY];
    const struct cml_outcome *outcome[2];
    double packets[2];
    int bins;
    const double *value[2]; /* [bins] as in the file */
    const double *error[2]; /* [bins] as in the file, NULL: none */
};

/* Neighbouring bins taken together. */
struct group {
    int first, last;
    double measure;               /* value times measure is weight per packet */
    double mean[2];               /* weight per packet */
    double squares[2], linear[2]; /* sums of the bins' errors */
    double rounding;              /* variance of the difference from printed digits */
};

/* What a group says: the variances of both means, and how many packets of the mean weight the smaller run has
 * in it. */
struct spread {
    double variance[2];   /* of each mean */
    double of_difference; /* of the difference of the means, without rounding */
    double packets;
    double freedom;
};

/* ---- the files ---- */

/* Fewer packets than batches make no error. */
static bool has_errors(const struct cml_outcome *o)
{
    if (o->photons < BATCHES) return false;
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

/* Says it of the second file, as if the first were right: one of them has to give way. */
static cml_status fail_grid(const char *const names[2], const char *field, double a, double b,
                            struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "%s: %s = %g (expected %g, as in %s)", names[1], field, b, a, names[0]);
}

/* Without equal bins there is nothing to compare bin by bin. Materials may differ: that is often the
 * question. */
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
        if (fabs(fields[i].a - fields[i].b) > printed * fields[i].a)
            return fail_grid(names, fields[i].field, fields[i].a, fields[i].b, err);
    return CML_OK;
}

/* ---- groups of bins ---- */

/* Standard deviation of what printing `digits` digits cut off. */
static double rounding_of(double value, int digits)
{
    return value > 0 ? pow(10, floor(log10(value)) + 1 - digits) / sqrt(12.0) : 0;
}

/* Both means, their errors added in both ways, and what the digits of both files leave open. Totals are
 * printed with six digits, bins with five. */
static void add_bin(const struct quantity *q, int i, struct group *group)
{
    const double measure = cml_outcome_measure(q->outcome[0], q->which, (size_t)i);
    const int digits = cml_quantity_is_total(q->which) ? 6 : 5;
    group->last = i;
    group->measure += measure;
    for (int k = 0; k < 2; k++) {
        const double error = q->error[k] ? q->error[k][i] * measure : 0;
        const double rounding = rounding_of(q->value[k][i], digits) * measure;
        group->mean[k] += q->value[k][i] * measure;
        group->squares[k] += error * error;
        group->linear[k] += error;
        group->rounding += rounding * rounding;
    }
}

/* What is left over at a profile's end joins the last group that was closed. */
static void join(struct group *group, const struct group *next)
{
    group->last = next->last;
    group->measure += next->measure;
    for (int k = 0; k < 2; k++) {
        group->mean[k] += next->mean[k];
        group->squares[k] += next->squares[k];
        group->linear[k] += next->linear[k];
    }
    group->rounding += next->rounding;
}

/* A packet leaves something in many bins of these, and does not score at most 1 in fluence. */
static bool is_deep(enum cml_quantity which)
{
    return which == CML_QUANTITY_A_z || which == CML_QUANTITY_A_rz || which == CML_QUANTITY_A_l_expected ||
           cml_quantity_is_fluence(which);
}

/* Variance of one packet's score from the file's own errors. */
static double own_variance(const struct quantity *q, const struct group *group, int k)
{
    const double n = q->packets[k];
    if (!is_deep(q->which) || group->first == group->last) return n * group->squares[k];
    const double most = n * group->linear[k] * group->linear[k];
    return q->which == CML_QUANTITY_A_z ? fmin(most, group->mean[k]) : most;
}

/* Packets of the mean weight that `n` launched ones leave in a group of this mean, when one launched packet's
 * score has this mean and variance: mean^2 / variance per packet. */
static double packets_in(double n, double mean, double variance)
{
    if (!(mean > 0)) return 0;
    return variance > 0 ? n * mean * (mean / variance) : INFINITY;
}

/* Mean square over mean of a packet's score, in the group's bins of file k or, where they hold too few
 * packets, in a wider range around them: their own scatter would go with their mean, and a low bin claim a
 * small error. 1, the largest for scores up to 1, when the whole profile has too few. */
static double typical_score(const struct quantity *q, const struct group *group, int k)
{
    const double enough = 500, n = q->packets[k];
    double mean = group->mean[k], square = n * group->squares[k] + mean * mean;
    for (int below = group->first - 1, above = group->last + 1;
         packets_in(n, mean, square) < enough && (below >= 0 || above < q->bins); below--, above++) {
        struct group next[2] = {{0}, {0}};
        if (below >= 0) add_bin(q, below, &next[0]);
        if (above < q->bins) add_bin(q, above, &next[1]);
        for (int i = 0; i < 2; i++) {
            mean += next[i].mean[k];
            square += n * next[i].squares[k] + next[i].mean[k] * next[i].mean[k];
        }
    }
    return packets_in(n, mean, square) >= enough ? square / mean : 1;
}

/* Whether errors of the file say how packets scatter: not where they were spread evenly (--sampling lattice),
 * which errors gain from. */
static bool packets_are_independent(const struct cml_outcome *o)
{
    return !(o->provenance.value[CML_DECIDES_sampling] > 0);
}

/* Variance per packet of a file without errors, and with it of the other: mean square less squared mean,
 * where the mean is that of both, or the file's own when it is larger, so that a chance excess is not
 * overrated. Only a lender that cannot say how packets scatter keeps its own. */
static void estimate(const struct quantity *q, const struct group *group, double mean, double variance[2])
{
    const int lender = q->error[0] ? 0 : 1;
    const bool lent = q->error[lender] != NULL, says = lent && packets_are_independent(q->outcome[lender]);
    const double score = says ? typical_score(q, group, lender) : 1;
    const double own = lent ? own_variance(q, group, lender) : 0;
    for (int k = 0; k < 2; k++) variance[k] = fmax(own, score * fmax(mean, group->mean[k]) - mean * mean);
    if (lent && !says) variance[lender] = own;
}

static bool is_by_groups(enum cml_quantity which)
{
    return cml_quantities[which].estimator == CML_FROM_GROUPS;
}

/* Degrees of freedom of the difference [Welch, Biometrika 34 (1947) 28]. */
static double freedom_of(const struct quantity *q, const double variance[2])
{
    const double each = is_by_groups(q->which) ? CML_NUM_GROUPS - 1 : BATCHES - 1,
                 sum = variance[0] + variance[1];
    if ((!q->error[0] && !q->error[1]) || !(sum > 0)) return INFINITY;
    if (!q->error[0] || !q->error[1]) return each;
    return each * sum * sum / (variance[0] * variance[0] + variance[1] * variance[1]);
}

/* When both files have errors, the larger of two estimates counts: each by its own variance (Welch), or
 * both by the common one, weighted by packets. */
static struct spread spread_of(const struct quantity *q, const struct group *group)
{
    const double n0 = q->packets[0], n1 = q->packets[1], n = n0 + n1;
    const double mean = (n0 * group->mean[0] + n1 * group->mean[1]) / n;
    struct spread s = {.packets = 0};
    double v[2]; /* per packet */
    if (q->error[0] && q->error[1])
        for (int k = 0; k < 2; k++) v[k] = own_variance(q, group, k);
    else
        estimate(q, group, mean, v);
    s.packets = packets_in(fmin(n0, n1), mean, (n0 * v[0] + n1 * v[1]) / n);
    s.variance[0] = v[0] / n0;
    s.variance[1] = v[1] / n1;
    const double common = (n0 * v[0] + n1 * v[1]) / n * (1 / n0 + 1 / n1);
    s.of_difference = fmax(s.variance[0] + s.variance[1], common);
    s.freedom = freedom_of(q, s.variance);
    return s;
}

/* Equal means agree whatever their errors: two runs that hold nothing have none. Errors come from batches, or
 * groups of them, so the quotient is a Student deviate (Student 1908, Biometrika 6, 1). */
static double deviate(const struct group *group, const struct spread *spread)
{
    const double difference = group->mean[0] - group->mean[1];
    if (difference == 0) return 0;
    return cml_normal_of_student(difference / sqrt(spread->of_difference + group->rounding), spread->freedom);
}

static int bins_of_radius(const struct quantity *q)
{
    switch (cml_quantities[q->which].axis[1]) {
    case CML_AXIS_z:
        return q->outcome[0]->nz;
    case CML_AXIS_alpha:
        return q->outcome[0]->na;
    default:
        return 1;
    }
}

/* What is shown are means over the group's bins, in the unit of the file. */
static struct cml_compare_test test_group(const struct quantity *q, const struct group *group)
{
    const struct spread spread = spread_of(q, group);
    const double width = cml_outcome_width(q->outcome[0], q->which), z = deviate(group, &spread);
    const int row = bins_of_radius(q);
    struct cml_compare_test test = {.quantity = q->which,
                                    .first = group->first,
                                    .last = group->last,
                                    .lower = group->first / row * width,
                                    .upper = (group->last / row + 1) * width,
                                    .z = z,
                                    .p = cml_two_sided(z)};
    memcpy(test.key, q->key, sizeof test.key);
    for (int k = 0; k < 2; k++) {
        test.value[k] = group->mean[k] / group->measure;
        test.error[k] = sqrt(spread.variance[k]) / group->measure;
    }
    return test;
}

/* ---- the comparison ---- */

/* Groups are closed where both runs together say so, never by one of them: that would favour its chance. */
static void test_quantity(const struct quantity *q, struct cml_comparison *c)
{
    const int begin = c->count;
    struct group group = {0}, closed = {0};
    for (int i = 0; i < q->bins; i++) {
        add_bin(q, i, &group);
        if (!(spread_of(q, &group).packets >= CML_COMPARE_PACKETS)) continue;
        c->test[c->count++] = test_group(q, &group);
        closed = group;
        group = (struct group){.first = i + 1};
    }
    if (c->count == begin) return;
    if (group.measure > 0) {
        join(&closed, &group);
        c->test[c->count - 1] = test_group(q, &closed);
    }
    c->bins[q->which] += q->bins;
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
           estimator == CML_FROM_EXPECTED || estimator == CML_FROM_GROUPS;
}

/* Both results' own part under one name: detectors may stand in another order, or be in one of them alone,
 * and layers be others. */
static void test_part(const struct cml_outcome *const outcome[2], enum cml_quantity which, int part,
                      struct cml_comparison *c)
{
    const size_t size = cml_outcome_part_size(outcome[0], which);
    struct quantity q = {.which = which, .bins = (int)size};
    if (cml_outcome_part_size(outcome[1], which) != size) return;
    cml_outcome_key(outcome[0], which, part, q.key);
    for (int k = 0; k < 2; k++) {
        const char *name = cml_quantity_is_of_detector(which) ? outcome[0]->detector[part] : NULL;
        const int own = name ? cml_outcome_find_detector(outcome[k], name, strlen(name)) : 0;
        if (own < 0) return;
        const double *error = errors_of(outcome[k], which);
        q.outcome[k] = outcome[k];
        q.packets[k] = (double)outcome[k]->photons;
        q.value[k] = outcome[k]->value[which] + (size_t)own * size;
        q.error[k] = error ? error + (size_t)own * size : NULL;
    }
    if (is_by_groups(which) && !(q.error[0] && q.error[1])) return;
    test_quantity(&q, c);
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
    c->p = c->worst < 0 ? 1 : cml_sidak(c->test[c->worst].p, c->count);
}

/* At most one test per bin and total, so the tests' memory is known beforehand. */
cml_status cml_compare(const struct cml_outcome *a, const struct cml_outcome *b, const char *const names[2],
                       struct cml_comparison *c, struct cml_error *err)
{
    const struct cml_outcome *const outcome[2] = {a, b};
    *c = (struct cml_comparison){.measured = {has_errors(a), has_errors(b)},
                                 .lends = {packets_are_independent(a), packets_are_independent(b)},
                                 .no_absorption = !tallied_absorption(a) || !tallied_absorption(b)};
    CML_TRY(check_grids(a, b, names, err));
    size_t tests = 0;
    for (int i = 0; i < CML_NUM_QUANTITIES; i++)
        if (cml_compare_tests((enum cml_quantity)i)) tests += cml_outcome_size(a, (enum cml_quantity)i);
    c->test = malloc(tests * sizeof *c->test);
    if (!c->test) return cml_fail_memory(err, (double)tests * sizeof *c->test, "the comparison");
    test_all(outcome, c);
    conclude(c);
    return CML_OK;
}

void cml_comparison_clear(struct cml_comparison *comparison)
{
    free(comparison->test);
    *comparison = (struct cml_comparison){0};
}
