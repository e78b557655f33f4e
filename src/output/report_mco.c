/* From tallies to the numbers of an .mco file.
 * SPDX-License-Identifier: MIT */
#include "output/report.h"

#include "output/report_parts.h"
#include "output/scaling.h"
#include "base/settings.h"
#include "base/version.h"
#include "surface/surface_facets.h"

#include <stdlib.h>
#include <string.h>

/* What the file repeats of the input, and the arrays. The whole of it may fail; cml_report_mco clears what
 * is there. */
static cml_status fill_input(const struct cml_report *report, struct cml_mco *mco, struct cml_error *err)
{
    const struct cml_scene *scene = report->scene;
    mco->photons = report->run->result.photons;
    mco->user_time = report->run->seconds;
    mco->dz = scene->dz;
    mco->dr = scene->dr;
    mco->nz = scene->nz;
    mco->nr = scene->nr;
    mco->na = scene->na;
    mco->num_layers = scene->num_layers;
    mco->n_above = scene->media[0].n;
    mco->n_below = scene->media[scene->num_layers + 1].n;
    CML_TRY(cml_mco_allocate(mco, err));
    mco->output = strdup(scene->output);
    if (!mco->output) return cml_fail_memory(err, 1, "a name");
    for (int l = 0; l < scene->num_layers; l++) {
        const struct cml_medium_def *m = &scene->media[l + 1];
        const double row[5] = {m->n, m->mua, m->mus, m->g, m->d};
        memcpy(mco->layer[l], row, sizeof row);
    }
    return CML_OK;
}

/* In MCML's order and units. A_z comes without batches where absorption was not tallied. */
void cml_report_profiles(const struct cml_report *report, struct cml_profile profiles[CML_PROFILES])
{
    const struct cml_scene *scene = report->scene;
    const struct cml_result *result = &report->run->result;
    const double da = cml_angle_width(scene->na);
    const struct cml_profile all[CML_PROFILES] = {
        {"A_z", "1/cm", result->A_z, scene->nz, scene->dz, cml_depth_width},
        {"Rd_r", "1/cm2", result->Rd_r, scene->nr, scene->dr, cml_ring_area},
        {"Rd_a", "sr-1", result->Rd_a, scene->na, da, cml_solid_angle},
        {"Tt_r", "1/cm2", result->Tt_r, scene->nr, scene->dr, cml_ring_area},
        {"Tt_a", "sr-1", result->Tt_a, scene->na, da, cml_solid_angle},
    };
    memcpy(profiles, all, sizeof all);
}

/* The error of the weight per photon, scaled like the value. */
double cml_profile_error(const struct cml_report *report, const struct cml_profile *profile, int i)
{
    return cml_result_bin_error(&report->run->result, profile->batches, profile->n, i) /
           profile->measure(profile->width, i);
}

/* Sections "se_KEY # [unit]", then one standard error per line. */
static void write_errors(FILE *out, const struct cml_report *report)
{
    struct cml_profile profiles[CML_PROFILES];
    cml_report_profiles(report, profiles);
    for (const struct cml_profile *p = profiles; p < profiles + CML_PROFILES; p++) {
        if (!p->batches) continue;
        fprintf(out, "\nse_%s # [%s]\n", p->name, p->units);
        for (int i = 0; i < p->n; i++) fprintf(out, "%12.4E\n", cml_profile_error(report, p, i));
    }
}

/* Sections `books` (the terms of the weight balance, P10), `residue` (by how much they do not balance) and
 * `lost`. The names are part of the file format and older than the words of the code. */
static void write_balance(FILE *out, const struct cml_result *result)
{
    fprintf(out,
            "\nbooks # weight per launched packet; launched + gained = all others up to lost, exactly\n");
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++)
        fprintf(out, "%.17g # %s\n", cml_result_share(result, (enum cml_balance_term)i),
                cml_result_book(i)->long_name);
    fprintf(out, "\nresidue # of the books, in 2^-31 packets; 0 unless the program is wrong\n%.17g\n",
            cml_result_imbalance(result));
    fprintf(out,
            "\nlost # packets; behind it the smallest of their indices, for `clustermcml trace`\n%.17g\n",
            (double)cml_result_lost(result));
    for (int i = 0; i < result->summary.lost.count; i++)
        fprintf(out, "%llu\n", (unsigned long long)result->summary.lost.index[i]);
}

/* The shape that was simulated, so that a plot can show it: r_0 h_0 r_1 h_1 ..., one number per line. Long
 * fields are left out: they would outgrow the results, and the .mci has them. */
static void write_heightfields(FILE *out, const struct cml_scene *scene)
{
    const int most = 10000;
    for (int b = 0; b <= scene->num_layers; b++) {
        const struct cml_radial *radial = &scene->boundaries[b].radial;
        if (scene->boundaries[b].form != CML_FORM_RADIAL || radial->n > most) continue;
        fprintf(out, "\nheightfield%d # r [cm] and h [cm] of boundary %d: r h pairs\n", b, b);
        for (int i = 0; i < radial->n; i++) fprintf(out, "%.9g\n%.9g\n", radial->r[i], radial->h[i]);
    }
}

/* Section `A_body`: what each body has absorbed, in the order of the file. A_l is for layers, as readers of
 * MCML's files expect. */
static void write_bodies(FILE *out, const struct cml_report *report)
{
    const struct cml_result *result = &report->run->result;
    const int first = report->scene->num_layers + 2;
    if (report->scene->num_bodies == 0) return;
    fprintf(out, "\nA_body # absorption in each body, in the order of the .mci [-]\n");
    for (int k = 0; k < report->scene->num_bodies; k++)
        fprintf(out, "%.9G\n", (double)result->A_l[first + k] * CML_WEIGHT_UNIT / (double)result->photons);
}

/* Section `flux_body`, where facets are asked for: what came to each body's surface from outside and from
 * inside, and left it to either side. Facets of bodies follow those of all boundaries. */
static void write_body_fluxes(FILE *out, const struct cml_report *report)
{
    const struct cml_result *result = &report->run->result;
    const struct cml_surface_set *surfaces = report->surfaces;
    size_t facet = 0;
    if (!report->scene->facets || surfaces->bodies.count == 0) return;
    for (int b = 0; b < surfaces->count; b++)
        facet += cml_surface_facets(&surfaces->item[b], &report->scene->map);
    fprintf(
        out,
        "\nflux_body # weight at each body's surface: arrives outside, inside, leaves outside, inside [-]\n");
    for (int k = 0; k < surfaces->bodies.count; k++) {
        double sum[CML_FACET_EXITANCE_BELOW + 1] = {0};
        for (uint64_t i = 0; i < surfaces->bodies.item[k].primitives; i++, facet++)
            for (int s = 0; s <= CML_FACET_EXITANCE_BELOW; s++)
                sum[s] += (double)result->facets[facet * CML_FACET_SCORES + (size_t)s];
        for (int s = 0; s <= CML_FACET_EXITANCE_BELOW; s++)
            fprintf(out, "%.9G\n", sum[s] * CML_WEIGHT_UNIT / (double)result->photons);
    }
}

/* How packets draw and end: what changes errors, and no expected value. */
static void write_sampling(FILE *out, const struct cml_engine_options *options)
{
    const struct cml_roulette_options *roulette = &options->roulette;
    fprintf(out, "# sampling %s, roulette ", cml_sampling_name(options));
    if (roulette->below > 0)
        fprintf(out, "below %g to %g\n", roulette->below, roulette->weight);
    else
        fprintf(out, "of original MCML\n");
}

/* The totals with the flat twin as control variate, then their standard errors, if it was flown. */
static void write_control(FILE *out, const struct cml_controlled *control)
{
    static const enum cml_total totals[] = {CML_TOTAL_SPECULAR, CML_TOTAL_REFLECTED, CML_TOTAL_ABSORBED,
                                            CML_TOTAL_TRANSMITTED};
    if (!control) return;
    fprintf(out, "\ncontrol # Rsp, Rd, A, Tt with the flat twin as control variate, then their errors [-]\n");
    for (int i = 0; i < CML_NUM_TOTALS; i++) fprintf(out, "%.9G\n", control[totals[i]].value);
    for (int i = 0; i < CML_NUM_TOTALS; i++) fprintf(out, "%.6G\n", control[totals[i]].error);
}

/* Everything behind Tt_ra, where readers of MCML's files have stopped. Lines that begin with # come first:
 * they are comments for those who read on. Nothing here may depend on time, threads, ranks or the machine. */
static void write_extra(FILE *out, const struct cml_report *report)
{
    const struct cml_scene *scene = report->scene;
    const struct cml_result *result = &report->run->result;
    const struct cml_engine_options *options = report->options;
    fprintf(out, "\n# clustermcml %s\n# engine %s, seed %llu, run %u, %s\n", cml_version(),
            report->engine->name, (unsigned long long)options->seed, options->run + 1,
            options->reentry ? "packets that leave may re-enter" : CML_MCO_FIRST_EXIT);
    write_sampling(out, options);
    cml_settings_print(out, "# set ", scene->settings);
    cml_report_beam(out, "# ", &scene->beam);
    cml_report_shapes(out, "# ", scene, report->surfaces, CML_READ_IN_MCO);
    fprintf(out, "\nlattice # 1: the packets of a batch depend on each other, 0: all are independent\n%d\n",
            options->lattice);
    fprintf(out, "\nse_RAT # Standard errors of Rsp, Rd, A, Tt [-]\n%.6G\n%.6G\n%.6G\n%.6G\n",
            cml_result_error(result, CML_TOTAL_SPECULAR), cml_result_error(result, CML_TOTAL_REFLECTED),
            cml_result_error(result, CML_TOTAL_ABSORBED), cml_result_error(result, CML_TOTAL_TRANSMITTED));
    write_errors(out, report);
    write_balance(out, result);
    write_bodies(out, report);
    write_body_fluxes(out, report);
    write_heightfields(out, scene);
    write_control(out, report->control);
}

/* As a text in memory, because the writer of .mco files knows no runs; a reader keeps it as a text, too. */
static cml_status fill_extra(const struct cml_report *report, struct cml_mco *mco, struct cml_error *err)
{
    size_t size = 0;
    FILE *out = open_memstream(&mco->extra, &size);
    if (!out) return cml_fail_memory(err, 1, "the report");
    write_extra(out, report);
    const int failed = ferror(out);
    if (fclose(out) != 0 || failed) return cml_fail_memory(err, (double)size, "the report");
    return CML_OK;
}

/* The text first: it is what may fail; scaling cannot. */
cml_status cml_report_mco(const struct cml_report *report, struct cml_mco *mco, struct cml_error *err)
{
    *mco = (struct cml_mco){0};
    cml_status status = fill_input(report, mco, err);
    if (status == CML_OK) status = fill_extra(report, mco, err);
    if (status != CML_OK) {
        cml_mco_clear(mco);
        return status;
    }
    cml_scale_result(&report->run->result, mco);
    return CML_OK;
}
