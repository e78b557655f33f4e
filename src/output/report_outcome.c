/* Makes the outcome of a run, the contents of its .mco and .h5: numbers of the scene, sums, and derivatives
 * from scores. SPDX-License-Identifier: MIT */
#include "output/report_parts.h"

#include "base/text.h"
#include "base/version.h"
#include "tally/row_cells.h"
#include "tally/row_result.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Copies the numbers of the input that the result repeats, and allocates the arrays. */
static cml_status fill_input(const struct cml_report *report, struct cml_outcome *o, struct cml_error *err)
{
    const struct cml_scene *scene = report->scene;
    o->photons = report->sums->photons;
    o->user_time = report->timing->seconds;
    o->dz = scene->dz;
    o->dr = scene->dr;
    o->nz = scene->nz;
    o->nr = scene->nr;
    o->na = scene->na;
    o->time_end = scene->time.end;
    o->num_gates = scene->time.gates;
    o->nt = scene->directions.nt;
    o->np = scene->directions.np;
    o->num_layers = scene->num_layers;
    o->num_bodies = scene->num_bodies;
    o->backed = scene->backing.kind != CML_BACKING_NONE;
    o->faced = scene->num_contacts > 0;
    o->n_above = scene->media[0].n;
    o->n_below = scene->media[scene->num_layers + 1].n;
    CML_TRY(cml_outcome_allocate(o, err));
    CML_TRY(cml_text_copy(scene->output, &o->output, err));
    for (int l = 0; l < scene->num_layers; l++) {
        const struct cml_medium_def *m = &scene->media[l + 1];
        const double row[CML_LAYER_NUMBERS] = {m->n, m->mua, m->mus, m->g, m->d};
        for (int i = 0; i < CML_LAYER_NUMBERS; i++) *cml_outcome_layer(o, l, i) = row[i];
    }
    return CML_OK;
}

/* Copies n, mua, mus and g of all bodies into the outcome. Media of bodies stand behind those of the layers,
 * the medium above and the medium below, hence `+ 2`. */
static cml_status fill_bodies(const struct cml_scene *scene, struct cml_outcome *o, struct cml_error *err)
{
    double **to = &o->value[CML_QUANTITY_body_n];
    for (int i = 0; scene->num_bodies > 0 && i <= CML_QUANTITY_body_g - CML_QUANTITY_body_n; i++)
        CML_TRY(cml_outcome_add(o, (enum cml_quantity)(CML_QUANTITY_body_n + i), false, err));
    for (int k = 0; k < scene->num_bodies; k++) {
        const struct cml_medium_def *m = &scene->media[scene->num_layers + 2 + k];
        to[0][k] = m->n;
        to[1][k] = m->mua;
        to[2][k] = m->mus;
        to[3][k] = m->g;
    }
    return CML_OK;
}

/* Copies the names of the detectors: one by one into o->detector, and joined by blanks into
 * o->detector_names. */
static cml_status fill_detectors(const struct cml_scene *scene, struct cml_outcome *o, struct cml_error *err)
{
    const int count = scene->num_detectors;
    size_t size = 0;
    if (count == 0) return CML_OK;
    CML_TRY(cml_zeros(&o->detector, (size_t)count, sizeof *o->detector, "detectors", err));
    FILE *out = open_memstream(&o->detector_names, &size);
    cml_status status = CML_OK;
    for (int k = 0; k < count; k++) {
        if (out) fprintf(out, "%s%s", k > 0 ? " " : "", scene->detectors[k].name);
        if (status == CML_OK) status = cml_text_copy(scene->detectors[k].name, &o->detector[k], err);
        if (status == CML_OK) o->num_detectors++;
    }
    const cml_status ended = cml_text_end(out, &o->detector_names, &size, "names of detectors", err);
    return status == CML_OK ? ended : status;
}

/* Sets the depths that each boundary spans, and the depths and distances from the z axis that the box around
 * each body spans: bins there are shared by several media. */
static cml_status fill_extents(const struct cml_report *report, struct cml_outcome *o, struct cml_error *err)
{
    const struct cml_surface_set *surfaces = report->surfaces;
    double **const of = o->value;
    for (int i = CML_QUANTITY_boundary_z_min; i <= CML_QUANTITY_body_r_max; i++)
        if (cml_outcome_size(o, (enum cml_quantity)i) > 0)
            CML_TRY(cml_outcome_add(o, (enum cml_quantity)i, false, err));
    for (int b = 0; b < surfaces->count; b++) {
        const struct cml_surface_def *def = &surfaces->item[b];
        const bool plane = def->kind == CML_SURFACE_PLANE;
        of[CML_QUANTITY_boundary_z_min][b] = def->depth + (plane ? 0 : def->lowest);
        of[CML_QUANTITY_boundary_z_max][b] = def->depth + (plane ? 0 : def->highest);
    }
    for (int k = 0; k < surfaces->bodies.count; k++) {
        const struct cml_body_surface *body = &surfaces->bodies.item[k];
        of[CML_QUANTITY_body_z_min][k] = body->depth + body->lower[2];
        of[CML_QUANTITY_body_z_max][k] = body->depth + body->upper[2];
        cml_report_reach(body, &of[CML_QUANTITY_body_r_min][k], &of[CML_QUANTITY_body_r_max][k]);
    }
    return CML_OK;
}

cml_status cml_report_words(struct cml_report *report, enum cml_report_reader reader, struct cml_error *err)
{
    struct cml_outcome *o = &report->outcome;
    char **const text[] = {&o->shapes, &o->beam, &o->phases, &o->detectors, &o->top};
    cml_status status = CML_OK;
    for (int i = 0; i < (int)(sizeof text / sizeof *text); i++) {
        size_t size = 0;
        free(*text[i]);
        *text[i] = NULL;
        FILE *out = open_memstream(text[i], &size);
        if (out && i == 0) cml_report_shapes(out, "", report->scene, report->surfaces, reader);
        if (out && i == 1) cml_report_beams(out, "", report->scene, NULL);
        if (out && i == 2) cml_report_phases(out, "", report->scene, reader);
        if (out && i == 3) cml_report_detectors(out, "", report->scene, reader);
        if (out && i == 4) cml_report_top(out, "", report->scene, reader);
        const cml_status ended = cml_text_end(out, text[i], &size, "the scene in words", err);
        if (ended != CML_OK) status = ended;
    }
    return status;
}

/* Finds for how many photons the saved packets are complete, if packets are saved, and stores the number in
 * report->covers. */
static cml_status count_covers(struct cml_report *report, struct cml_error *err)
{
    const struct cml_scene *scene = report->scene;
    CML_AT_END(cml_deal_clear) struct cml_deal run = {0};
    if (!report->sums->saved) return CML_OK;
    CML_TRY(cml_deal_create(scene->shares, scene->num_beams, &run, err));
    CML_TRY(cml_deal_round(&run, 0, report->sums->photons, err));
    cml_saved_sort(report->sums->saved);
    report->covers = cml_saved_covers(report->sums->saved, &run);
    return CML_OK;
}

/* ---- derivatives ---- The scores of a run (P17) are sums of w times a length, in a unit of its medium, or
 * of w times interactions less those expected. */

/* Returns the factor from score 2 k + by_mus to a derivative. NaN where the score says nothing: by mus in a
 * medium that does not scatter; by mua in a clear first layer, below which beams start (P1); by mua in any
 * clear medium once packets were given up as trapped (P9), because their paths there have no end. */
static double scale_of(const struct cml_report *report, int k, bool by_mus)
{
    const struct cml_scene *scene = report->scene;
    const struct cml_medium_def *medium = &scene->media[cml_medium_inside(scene->num_layers, k)];
    const double mut = cml_medium_mut(medium);
    const bool ends = k > 0 && report->sums->summary.count[CML_COUNT_TRAPPED] == 0;
    if (by_mus) return medium->mus > 0 ? 1 / medium->mus : NAN;
    return ends || mut > 0 ? -1 / cml_score_unit(mut) : NAN;
}

/* Fills column k (a medium) of the derivative `quantity` from the sums of the medium's score. `scale` turns
 * a score into a derivative and may be negative, hence fabs for the error. */
static cml_status take_column(const struct cml_outcome *sums, enum cml_quantity quantity, int k, double scale,
                              struct cml_outcome *o, struct cml_error *err)
{
    const enum cml_quantity of = (enum cml_quantity)cml_quantities[quantity].sums;
    const size_t columns = (size_t)cml_outcome_bins(o, CML_AXIS_inside);
    if (!sums->value[of] || cml_outcome_size(sums, of) == 0) return CML_OK;
    CML_TRY(cml_outcome_add(o, quantity, false, err));
    CML_TRY(cml_outcome_add(o, quantity, true, err));
    for (size_t i = 0; i < cml_outcome_size(sums, of); i++) {
        /* + 0.0 turns -0 into 0 */
        o->value[quantity][i * columns + (size_t)k] = scale * sums->value[of][i] + 0.0;
        o->error[quantity][i * columns + (size_t)k] = fabs(scale) * sums->error[of][i];
    }
    return CML_OK;
}

/* Computes the derivatives with respect to mua or mus (by_mus) of medium k. The medium's score has sums like
 * a result of its own, which are turned into quantities first. */
static cml_status take_score(const struct cml_report *report, int k, bool by_mus, struct cml_outcome *o,
                             struct cml_error *err)
{
    const double scale = scale_of(report, k, by_mus);
    CML_AT_END(cml_result_free) struct cml_result result = {0};
    struct cml_outcome sums = {.photons = o->photons,
                               .dz = o->dz,
                               .dr = o->dr,
                               .nz = o->nz,
                               .nr = o->nr,
                               .na = o->na,
                               .num_layers = o->num_layers,
                               .num_bodies = o->num_bodies,
                               .num_detectors = o->num_detectors,
                               .backed = o->backed,
                               .faced = o->faced};
    CML_TRY(cml_score_result(report->sums, 2 * k + by_mus, &result, err));
    cml_status status = cml_outcome_take(&sums, &result, err);
    for (int i = 0; status == CML_OK && i < CML_NUM_QUANTITIES; i++) {
        const enum cml_quantity quantity = (enum cml_quantity)i;
        if (cml_quantities[i].estimator == (by_mus ? CML_FROM_MUS : CML_FROM_MUA))
            status = take_column(&sums, quantity, k, scale, o, err);
    }
    /* `sums` has no names of detectors that cml_outcome_clear could free */
    sums.num_detectors = 0;
    cml_outcome_clear(&sums);
    return status;
}

/* Fills in the derivatives of the totals. Each medium has two scores, for mua and for mus, hence score / 2
 * and score % 2. */
static cml_status fill_derivatives(const struct cml_report *report, struct cml_outcome *o,
                                   struct cml_error *err)
{
    for (int score = 0; report->sums->grid.derivatives && score < report->sums->grid.rows; score++)
        CML_TRY(take_score(report, score / 2, score % 2 == 1, o, err));
    return CML_OK;
}

/* ---- the whole outcome ---- */

/* Computes all that .mco and .h5 of the run contain besides fields. Steps that can fail for lack of memory
 * come first. */
static cml_status fill(struct cml_report *report, struct cml_error *err)
{
    struct cml_outcome *o = &report->outcome;
    const char *settings = report->scene->settings;
    o->provenance = *report->provenance;
    memcpy(o->identity, report->identity, sizeof o->identity);
    CML_TRY(cml_text_copy(cml_version(), &o->program, err));
    if (settings) CML_TRY(cml_text_copy(settings, &o->settings, err));
    CML_TRY(cml_report_words(report, CML_READ_IN_MCO, err));
    CML_TRY(fill_detectors(report->scene, o, err));
    CML_TRY(fill_input(report, o, err));
    CML_TRY(fill_bodies(report->scene, o, err));
    CML_TRY(fill_extents(report, o, err));
    CML_TRY(count_covers(report, err));
    CML_TRY(cml_report_body_fluxes(report, o, err));
    CML_TRY(cml_outcome_take(o, report->sums, err));
    return fill_derivatives(report, o, err);
}

cml_status cml_report_outcome(struct cml_report *report, struct cml_error *err)
{
    report->outcome = (struct cml_outcome){0};
    const cml_status status = fill(report, err);
    if (status != CML_OK) cml_outcome_clear(&report->outcome);
    return status;
}

/* ---- derivatives for people ---- */

/* Prints a line for a medium: "  layer 2: dRd_dmua -0.1 +- 0.002, dTt_dmua ...". */
static void print_medium(FILE *stream, const struct cml_outcome *o, int k)
{
    const enum cml_quantity shown[] = {
        CML_QUANTITY_dRd_dmua, o->backed ? CML_QUANTITY_dA_backing_dmua : CML_QUANTITY_dTt_dmua,
        CML_QUANTITY_dRd_dmus, o->backed ? CML_QUANTITY_dA_backing_dmus : CML_QUANTITY_dTt_dmus};
    const bool body = k >= o->num_layers;
    fprintf(stream, "  %s %d:", body ? "body" : "layer", body ? k - o->num_layers + 1 : k + 1);
    for (size_t i = 0; i < sizeof shown / sizeof *shown; i++)
        fprintf(stream, "%s %s %.4g +- %.2g", i > 0 ? "," : "", cml_quantities[shown[i]].name,
                o->value[shown[i]][k], o->error[shown[i]][k]);
    fputs(" cm\n", stream);
}

void cml_report_print_derivatives(FILE *stream, const struct cml_report *report)
{
    enum { MOST = 16 }; /* the files have all media */
    const struct cml_outcome *o = &report->outcome;
    const int media = report->sums->grid.derivatives ? o->num_layers + o->num_bodies : 0;
    for (int k = 0; k < media && k < MOST; k++) print_medium(stream, o, k);
}
