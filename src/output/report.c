/* SPDX-License-Identifier: MIT */
#include "output/report_parts.h"

#include <math.h>
#include <string.h>

/* True for a value that fixed decimals would show with few digits. */
static bool is_small(double value)
{
    return value > 0 && value < 1e-4;
}

/* NaN means that a single packet leaves no spread to take an error from. */
void cml_report_estimate(FILE *stream, double value, double error)
{
    const bool small = is_small(value);
    fprintf(stream, small ? " %.3e " : " %.6f ", value);
    if (isnan(error))
        fputs("(one packet: no standard error)", stream);
    else
        fprintf(stream, small ? "+- %.1e" : "+- %.6f", error);
}

/* Returns the error as shown: 0 for a limit of underflow (CML_LEAST_THROUGH), which is nothing beside the
 * other errors. */
static double shown_limit(double error)
{
    return error < 1e-99 ? 0 : error;
}

/* If this many packets are expected, none comes with a probability of exp(-3) = 5 %. */
#define LEFT_UNSEEN 3.0

/* True for a total that no packet has reached, though light that entered may reach it: an error of 0 says
 * nothing then. A backing lets no light pass. */
static bool left_unseen(const struct cml_report *report, enum cml_total total)
{
    const bool passes = total == CML_TOTAL_REFLECTED ||
                        (total == CML_TOTAL_TRANSMITTED && report->scene->backing.kind == CML_BACKING_NONE);
    return passes && !(cml_result_total(report->sums, total) > 0);
}

/* Prints a total with its standard error, and its exact value with the limit of its error. The letters are
 * those of MCML. */
static void print_total(FILE *stream, const struct cml_report *report, enum cml_total total)
{
    fprintf(stream, "  %-4s", cml_quantities[cml_quantity_of_total((int)total)].name);
    cml_report_estimate(stream, cml_result_total(report->sums, total), cml_result_error(report->sums, total));
    if (report->exact)
        fprintf(stream,
                is_small(report->exact->value[total]) ? "   exact %.4e +- %.1g" : "   exact %.7f +- %.1g",
                report->exact->value[total], shown_limit(report->exact->error[total]));
    if (left_unseen(report, total))
        fprintf(stream, "   no packet came: below %.2g at 95 %%",
                LEFT_UNSEEN / (double)report->sums->photons);
    fputc('\n', stream);
}

/* Media and detectors printed for people at most; the result files have all. */
#define MOST_MEDIA 16
#define LEAST_BATCHES 4 /* batches that must have seen something, for an error to mean anything */

/* Prints the absorption of each layer and body, unless a single layer has all of it. */
static void print_absorbed(FILE *stream, const struct cml_report *report)
{
    const int layers = report->scene->num_layers, bodies = report->scene->num_bodies;
    for (int k = 0; k < layers + bodies && layers + bodies > 1; k++) {
        const int medium = k < layers ? k + 1 : k + 2;
        if (k == MOST_MEDIA) {
            fprintf(stream, "  A of %d more layers and bodies: A_l and A_body of the result\n",
                    layers + bodies - k);
            return;
        }
        const char *name = k < layers ? cml_layer_name(report->scene, medium) : "";
        fprintf(stream, "  A of %s %d", k < layers ? "layer" : "body", k < layers ? k + 1 : k - layers + 1);
        if (*name) fprintf(stream, " (%s)", name);
        cml_report_estimate(stream, cml_result_absorbed(report->sums, medium),
                            cml_result_absorbed_error(report->sums, medium));
        fputc('\n', stream);
    }
}

/* Prints a detector that has seen nothing: without a packet there is no error. */
static void print_unseen(FILE *stream, const struct cml_report *report, int k)
{
    const char *name = report->scene->detectors[k].name;
    fprintf(stream, ": saw none of %.0f photons", (double)report->sums->photons);
    if (report->unseen == k + 1) fprintf(stream, "; --aim %s would split packets on their way to it", name);
}

/* Warns of an error from few batches: a single packet may have brought the whole value. */
static void print_rare(FILE *stream, const struct cml_result *result, int k)
{
    int batches = 0;
    for (int b = 0; b < CML_NUM_BATCHES; b++)
        batches += result->detector[(size_t)b * (size_t)result->grid.detectors + (size_t)k] > 0;
    if (batches < LEAST_BATCHES)
        fprintf(stream, ", of %d of %d batches: too few to trust", batches, CML_NUM_BATCHES);
}

/* Prints what each detector has seen, with its error. A detector that saw nothing gets a hint why. After
 * MOST_MEDIA detectors, only the number of the others is printed. */
static void print_detected(FILE *stream, const struct cml_report *report)
{
    const struct cml_result *result = report->sums;
    const int detectors = report->scene->num_detectors;
    for (int k = 0; k < detectors; k++) {
        if (k == MOST_MEDIA) {
            fprintf(stream, "  %d more detectors: in the result\n", detectors - k);
            return;
        }
        fprintf(stream, "  detector %s", report->scene->detectors[k].name);
        const double seen = cml_result_bin_sum(result->detector, detectors, k) * CML_WEIGHT_UNIT;
        if (seen > 0) {
            cml_report_estimate(stream, seen / (double)result->photons,
                                cml_result_bin_error(result, result->detector, detectors, k));
            print_rare(stream, result, k);
        } else {
            print_unseen(stream, report, k);
        }
        fputc('\n', stream);
    }
}

/* Prints the boundaries whose shape is ignored. */
static void print_flattened(FILE *stream, const struct cml_scene *scene)
{
    for (int b = 0; b <= scene->num_layers; b++)
        if (cml_boundary_has_shape(&scene->boundaries[b]))
            fprintf(stream, "  boundary %d counts as a plane\n", b);
}

void cml_report_exact(FILE *stream, const struct cml_scene *scene, const struct cml_exact *exact)
{
    fprintf(stream, "%s (%s:%d): adding-doubling, order %d", scene->output, scene->file, scene->line,
            exact->order);
    if (exact->walks > 0) fprintf(stream, ", %.0f walks at each rough boundary", exact->walks);
    fputc('\n', stream);
    print_flattened(stream, scene);
    for (int i = 0; i < exact->count; i++) {
        if (i == CML_EXACT_BACKING && scene->backing.kind == CML_BACKING_NONE) continue;
        if (i < CML_EXACT_LAYERS)
            fprintf(stream, "  %-4s", cml_quantities[cml_quantity_of_total(i)].name);
        else
            fprintf(stream, "  A of layer %d", i - CML_EXACT_LAYERS + 1);
        fprintf(stream, exact->value[i] > 0 && exact->value[i] < 1e-3 ? " %.8e +- %.1g\n" : " %.9f +- %.1g\n",
                exact->value[i], shown_limit(exact->error[i]));
    }
    if (!exact->converged)
        fprintf(stream, "  errors are above the aim at the highest order that was tried\n");
}

void cml_report_flat_twin(FILE *stream, const struct cml_scene *scene, const struct cml_exact *exact)
{
    fprintf(stream, "  with planes in place of all shapes, by adding-doubling:");
    for (int i = 0; i < CML_NUM_TOTALS; i++)
        if (cml_has_total(i, scene->backing.kind != CML_BACKING_NONE, false))
            fprintf(stream, is_small(exact->value[i]) ? " %s %.4e" : " %s %.7f",
                    cml_quantities[cml_quantity_of_total(i)].name, exact->value[i]);
    fprintf(stream, ", errors <= %.1g\n", cml_exact_worst(exact));
}

/* Prints warnings of rare events that happened in the run: lost packets with the command that traces them,
 * limited splits, and weight outside of the grid. run: the number of the run in its file. */
static void print_rarities(FILE *stream, const struct cml_result *result, double run)
{
    static const struct {
        enum cml_count count;
        const char *text;
    } rarities[] = {
        {CML_COUNT_TRAPPED, "packets given up as trapped in a clear medium"},
        {CML_COUNT_LOST_NO_SURFACE, "packets lost: no surface found"},
        {CML_COUNT_LOST_NAN, "packets lost: not a number"},
        {CML_COUNT_LOST_STUCK, "packets lost: stuck"},
        {CML_COUNT_LOST_LEAKED, "packets lost: leaked through a boundary"},
        {CML_COUNT_LOST_TOO_FAR, "packets lost: flew too far over a tile"},
        {CML_COUNT_LOST_ROUGH, "packets lost: met 1000 facets of a rough boundary at once"},
        {CML_COUNT_UNSPLIT, "packets not split, as no more could wait: bytes may depend on threads"},
        {CML_COUNT_CLIPPED, "splits into 64 parts, the most, of packets that were to have more"},
        {CML_COUNT_SPENT, "splits into fewer parts than wanted: of a photon come at most 1e6 on average"},
        {CML_COUNT_SHADING_OVERRULED, "boundary events where the facet overruled the shading normal"},
    };
    for (size_t i = 0; i < sizeof rarities / sizeof *rarities; i++)
        if (result->summary.count[rarities[i].count] > 0)
            fprintf(stream, "  %.0f %s\n", (double)result->summary.count[rarities[i].count],
                    rarities[i].text);
    for (int i = 0; i < result->summary.lost.count; i++)
        fprintf(stream, "  lost: clustermcml trace ... %llu --run %.0f\n",
                (unsigned long long)result->summary.lost.index[i], run);
    const double overflow = cml_result_share(result, CML_BALANCE_OVERFLOW_R);
    if (overflow > 0)
        fprintf(stream, "  %.4g of the weight was scored beyond r = nr dr, in the last bin\n", overflow);
    const double below = cml_result_share(result, CML_BALANCE_OVERFLOW_Z);
    if (below > 0)
        fprintf(stream, "  %.4g of the weight was absorbed below z = nz dz, in the last bin\n", below);
    const double above = cml_result_share(result, CML_BALANCE_ABOVE);
    if (above > 0)
        fprintf(stream, "  %.4g of the weight was absorbed above z = 0, in the first bin\n", above);
}

/* Prints the seconds that an error of 1 % would take on this machine, for each total that was seen. */
static void print_seconds_to(FILE *stream, const struct cml_report *report)
{
    const char *before = "  an error of 1 % takes: ";
    for (size_t i = 0; i < CML_NUM_GOALS; i++) {
        const double seconds =
            report->timing->seconds * cml_result_times_to(report->sums, cml_goals[i], 0.01);
        if (!isfinite(seconds)) continue;
        fprintf(stream, "%s%s %.2g s", before, cml_quantities[cml_goals[i]].name, seconds);
        before = ", ";
    }
    if (before[0] == ',') fputc('\n', stream);
}

/* Prints the expected values, which have smaller errors than the counted totals, and how many times the
 * photons a counted total would need for the same error. */
static void print_expected(FILE *stream, const struct cml_report *report)
{
    const struct cml_result *sums = report->sums;
    const double counted = cml_result_error(sums, CML_TOTAL_TRANSMITTED);
    for (int s = 0; report->tail && s < report->tail->scores; s++) {
        double value, error;
        cml_result_expected(sums, s, &value, &error);
        if (s == 0)
            fprintf(stream, "  Tt  ");
        else
            fprintf(stream, "  A of layer %d", report->tail->layer + s);
        fprintf(stream, " %.6g +- %.2g expected", value, error);
        if (s == 0 && counted > 0 && error > 0)
            fprintf(stream, ", as by %.2g times the photons", counted / error * (counted / error));
        fputc('\n', stream);
    }
}

/* Prints how many packets were saved, and how many others were found but are not in the file. */
static void print_saved(FILE *stream, const struct cml_report *report)
{
    const struct cml_result *sums = report->sums;
    if (!sums->saved) return;
    const struct cml_saved_sums kept = cml_saved_sort(sums->saved);
    fprintf(stream, "  saved: %.0f packets that %s", (double)kept.kept,
            report->scene->saved.detected ? "were detected" : "left");
    if (kept.found > kept.kept)
        fprintf(stream, ", of %.0f (limit=): all of %s %.0f photons, none of others", (double)kept.found,
                report->scene->num_beams > 1 ? "a sample of" : "the first", (double)report->covers);
    fputc('\n', stream);
}

/* Prints how many parts of packets windows split off (P19), if any. */
static void print_parts(FILE *stream, const struct cml_result *result)
{
    const double parts = (double)result->summary.count[CML_COUNT_BRANCHES];
    if (parts > 0)
        fprintf(stream, "  %.3g parts of packets a photon were split off\n", parts / (double)result->photons);
}

#define LEAST_TRAPPED 1e-6 /* least share of the light that is reported as trapped */

/* Prints the share of light in packets that were given up (P9), which no total includes. Nobody knows whether
 * this light was trapped for ever, or would have come out later. */
static void print_trapped(FILE *stream, const struct cml_result *result)
{
    const double share = cml_result_share(result, CML_BALANCE_TRAPPED);
    if (!(share > LEAST_TRAPPED)) return;
    fprintf(stream, is_small(share) ? "  trapped %.3e" : "  trapped %.6f", share);
    fputs(" of the light, given up in a clear medium: each result may lack up to as much (a mua of 1e-3 1/cm "
          "there shows where it goes)\n",
          stream);
}

/* Output says `books` and `residue` for the balance and what it leaves over. Steps are interactions and
 * boundary events. */
void cml_report_summary(FILE *stream, const struct cml_report *report)
{
    const struct cml_result *result = report->sums;
    const double seconds = report->timing->seconds, steps = cml_result_steps(result);
    const struct cml_outcome *o = &report->outcome;
    for (int i = 0; i < CML_NUM_TOTALS; i++)
        if (cml_has_total(i, o->backed, o->faced)) print_total(stream, report, (enum cml_total)i);
    print_trapped(stream, result);
    print_absorbed(stream, report);
    print_detected(stream, report);
    print_expected(stream, report);
    fprintf(stream, "  books: residue %.17g, roulette +%.3g -%.3g, lost %llu\n", cml_result_imbalance(result),
            cml_result_share(result, CML_BALANCE_GAINED), cml_result_share(result, CML_BALANCE_ROULETTE),
            (unsigned long long)cml_result_lost(result));
    print_rarities(stream, result, report->provenance->value[CML_DECIDES_run]);
    print_saved(stream, report);
    print_parts(stream, result);
    fprintf(stream, "  %.3g s, %llu photons, %.3g photons/s, %.3g steps", seconds,
            (unsigned long long)result->photons, (double)result->photons / seconds, steps);
    if (steps > 0) fprintf(stream, ", %.3g ns/step", 1e9 * seconds / steps);
    if (report->timing->threads == 0)
        fputs(" in all parts\n", stream);
    else
        fprintf(stream, " on %d thread%s\n", report->timing->threads,
                report->timing->threads == 1 ? "" : "s");
    print_seconds_to(stream, report);
    if (!isnan(report->flat_below) && !report->exact)
        fprintf(stream, "  all is flat below z = %.4g cm: --aim Tt would give Tt a smaller error\n",
                report->flat_below);
}

void cml_report_ranks(FILE *stream, const struct cml_timing *timing)
{
    fprintf(stream, "  %4s %14s %8s %8s %8s %8s\n", "rank", "photons", "flying %", "idle %", "asking %",
            "sums %");
    for (int i = 0; i < timing->ranks; i++) {
        const struct cml_rank_report *rank = &timing->rank[i];
        const double percent = 100 / rank->elapsed;
        fprintf(stream, "  %4d %14llu %8.2f %8.2f %8.2f %8.2f\n", i, (unsigned long long)rank->photons,
                percent * rank->flying, percent * rank->waiting, percent * rank->asking,
                percent * rank->summing);
    }
    fprintf(stream, "  all ranks: idle %.2f %%, communication %.2f %%\n", 100 * cml_timing_idle(timing),
            100 * cml_timing_communication(timing));
}
