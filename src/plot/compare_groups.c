/* SPDX-License-Identifier: MIT */
#include "plot/compare_groups.h"

#include "base/significance.h"

#include <math.h>
#include <string.h>

/* What a group says: the variances of both means, and how many packets of the mean weight the smaller run has
 * in it. */
struct spread {
    double variance[2];   /* of each mean */
    double of_difference; /* of the difference of the means, without rounding */
    double packets;
    double freedom;
};
/* ---- groups of bins ---- */

/* Standard deviation of what printing `digits` digits cut off. */
static double rounding_of(double value, int digits)
{
    return value != 0 ? pow(10, floor(log10(fabs(value))) + 1 - digits) / sqrt(12.0) : 0;
}

/* Both means, their errors added in both ways, and what the digits of both files leave open. Totals are
 * printed with six digits, bins with five. */
static void add_bin(const struct cml_compare_quantity *q, int i, struct cml_compare_group *group)
{
    const bool of_files = cml_compare_is_of_files(q->which);
    const double measure = of_files ? 1 : cml_outcome_measure(q->outcome[0], q->which, (size_t)i);
    const int at = i - q->begin; /* among the bins that are here */
    const int digits = cml_quantity_is_total(q->which) ? 6 : 5;
    group->last = i;
    group->measure += measure;
    for (int k = 0; k < 2; k++) {
        const double error = q->error[k] ? q->error[k][at] * measure : 0;
        const double rounding = rounding_of(q->value[k][at], digits) * measure;
        group->mean[k] += q->value[k][at] * measure;
        group->squares[k] += error * error;
        group->linear[k] += error;
        group->rounding += rounding * rounding;
    }
}

/* What is left over at a profile's end joins the last group that was closed. */
static void join(struct cml_compare_group *group, const struct cml_compare_group *next)
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

/* Of arrays of .h5 files all but pixels, in one of which a packet ends. */
static bool is_deep_of_files(enum cml_quantity which)
{
    const enum cml_axis_kind axis = cml_quantities[which].axis[0];
    return cml_compare_is_of_files(which) && axis != CML_AXIS_y && axis != CML_AXIS_detector;
}

/* A packet leaves something in many bins of these, and does not score at most 1 in fluence. */
static bool is_deep(enum cml_quantity which)
{
    return which == CML_QUANTITY_A_z || which == CML_QUANTITY_A_rz || which == CML_QUANTITY_A_l_expected ||
           cml_compare_comes_of(which, CML_FROM_LAYERS) || cml_compare_comes_of(which, CML_FROM_BODIES) ||
           cml_quantity_is_fluence(which) || is_deep_of_files(which);
}

/* Variance of one packet's score from the file's own errors. */
static double own_variance(const struct cml_compare_quantity *q, const struct cml_compare_group *group, int k)
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
static double typical_score(const struct cml_compare_quantity *q, const struct cml_compare_group *group,
                            int k)
{
    const double enough = 500, n = q->packets[k];
    double mean = group->mean[k], square = n * group->squares[k] + mean * mean;
    for (int below = group->first - 1, above = group->last + 1;
         packets_in(n, mean, square) < enough && (below >= 0 || above < q->bins); below--, above++) {
        struct cml_compare_group next[2] = {{0}, {0}};
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
bool cml_compare_lends(const struct cml_outcome *o)
{
    return !(o->provenance.value[CML_DECIDES_sampling] > 0);
}

/* Variance per packet of a file without errors, and with it of the other: mean square less squared mean,
 * where the mean is that of both, or the file's own when it is larger, so that a chance excess is not
 * overrated. Only a lender that cannot say how packets scatter keeps its own. */
static void estimate(const struct cml_compare_quantity *q, const struct cml_compare_group *group, double mean,
                     double variance[2])
{
    const int lender = q->error[0] ? 0 : 1;
    const bool lent = q->error[lender] != NULL, says = lent && cml_compare_lends(q->outcome[lender]);
    const double score = says ? typical_score(q, group, lender) : 1;
    const double own = lent ? own_variance(q, group, lender) : 0;
    for (int k = 0; k < 2; k++) variance[k] = fmax(own, score * fmax(mean, group->mean[k]) - mean * mean);
    if (lent && !says) variance[lender] = own;
}

/* Errors of arrays of files come from groups, or from squares, which know more. */
static bool is_by_groups(enum cml_quantity which)
{
    return cml_compare_comes_of(which, CML_FROM_GROUPS) || cml_compare_comes_of(which, CML_FROM_ONCE) ||
           cml_compare_is_of_files(which);
}

/* Degrees of freedom of the difference [Welch, Biometrika 34 (1947) 28]. */
static double freedom_of(const struct cml_compare_quantity *q, const double variance[2])
{
    const double each = is_by_groups(q->which) ? CML_NUM_GROUPS - 1 : CML_COMPARE_BATCHES - 1,
                 sum = variance[0] + variance[1];
    if ((!q->error[0] && !q->error[1]) || !(sum > 0)) return INFINITY;
    if (!q->error[0] || !q->error[1]) return each;
    return each * sum * sum / (variance[0] * variance[0] + variance[1] * variance[1]);
}

/* When both files have errors, the larger of two estimates counts: each by its own variance (Welch), or
 * both by the common one, weighted by packets. */
static struct spread spread_of(const struct cml_compare_quantity *q, const struct cml_compare_group *group)
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
static double deviate(const struct cml_compare_group *group, const struct spread *spread)
{
    const double difference = group->mean[0] - group->mean[1];
    if (difference == 0) return 0;
    return cml_normal_of_student(difference / sqrt(spread->of_difference + group->rounding), spread->freedom);
}

static int bins_of_radius(const struct cml_compare_quantity *q)
{
    const enum cml_axis_kind axis = cml_quantities[q->which].axis[1];
    return axis == CML_AXIS_z || axis == CML_AXIS_alpha ? cml_outcome_bins(q->outcome[0], axis) : 1;
}

/* What is shown are means over the group's bins, in the unit of the file. */
static struct cml_compare_test test_group(const struct cml_compare_quantity *q,
                                          const struct cml_compare_group *group)
{
    const struct spread spread = spread_of(q, group);
    const double width = cml_outcome_width(q->outcome[0], q->which), z = deviate(group, &spread);
    const int row = bins_of_radius(q);
    struct cml_compare_test test = {.quantity = q->which,
                                    .first = group->first,
                                    .last = group->last,
                                    .lower = q->shape[0] ? 0 : group->first / row * width,
                                    .upper = q->shape[0] ? 0 : (group->last / row + 1) * width,
                                    .z = z,
                                    .p = cml_two_sided(z)};
    memcpy(test.key, q->key, sizeof test.key);
    memcpy(test.shape, q->shape, sizeof test.shape);
    for (int k = 0; k < 2; k++) {
        test.value[k] = group->mean[k] / group->measure;
        test.error[k] = sqrt(spread.variance[k]) / group->measure;
    }
    return test;
}
/* ---- tests ---- */

/* Of an array of files the worst alone is listed. */
static void note_test(const struct cml_compare_quantity *q, const struct cml_compare_group *group,
                      struct cml_compare_scan *scan, struct cml_comparison *c)
{
    const struct cml_compare_test test = test_group(q, group);
    c->tests++;
    c->tests_of[q->which]++;
    if (scan->tests++ == 0 || !cml_compare_is_of_files(q->which))
        c->test[c->count++] = test;
    else if (fabs(test.z) > fabs(c->test[c->count - 1].z))
        c->test[c->count - 1] = test;
}

/* Groups are closed where both runs together say so, never by one of them: that would favour its chance. A
 * group is tested when the next one is closed, as it takes what is left over. */
void cml_compare_scan_bins(const struct cml_compare_quantity *q, int end, struct cml_compare_scan *scan,
                           struct cml_comparison *c)
{
    for (int i = q->begin; i < end; i++) {
        add_bin(q, i, &scan->open);
        if (!(spread_of(q, &scan->open).packets >= CML_COMPARE_PACKETS)) continue;
        if (scan->closed.measure > 0) note_test(q, &scan->closed, scan, c);
        scan->closed = scan->open;
        scan->open = (struct cml_compare_group){.first = i + 1};
    }
}

void cml_compare_end_scan(const struct cml_compare_quantity *q, struct cml_compare_scan *scan,
                          struct cml_comparison *c)
{
    if (!(scan->closed.measure > 0)) return;
    if (scan->open.measure > 0) join(&scan->closed, &scan->open);
    note_test(q, &scan->closed, scan, c);
    c->bins[q->which] += q->bins;
}

void cml_compare_one_bin(const struct cml_compare_quantity *q, int i, struct cml_compare_scan *scan,
                         struct cml_comparison *c)
{
    struct cml_compare_group group = {.first = i};
    add_bin(q, i, &group);
    note_test(q, &group, scan, c);
}
