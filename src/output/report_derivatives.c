/* What a run's scores say (kernels/README.md, P17): derivatives by mua and mus of every medium inside. A
 * score is the sum of w times a length, in a unit of its medium, or of w times interactions less those
 * expected. SPDX-License-Identifier: MIT */
#include "output/report_parts.h"

#include "tally/row_cells.h"
#include "tally/row_result.h"

#include <math.h>

/* The factor of the sums of score number 2 k + by_mus. NaN where the score knows nothing: by mus of a medium
 * that does not scatter; by mua of a clear first layer, below which beams start (P1); by mua of any clear
 * medium once packets were given up as trapped (P9), for their paths there have no end. */
static double scale_of(const struct cml_report *report, int k, bool by_mus)
{
    const struct cml_scene *scene = report->scene;
    const struct cml_medium_def *medium = &scene->media[cml_medium_inside(scene->num_layers, k)];
    const double mut = cml_medium_mut(medium);
    const bool ends = k > 0 && report->sums->summary.count[CML_COUNT_TRAPPED] == 0;
    if (by_mus) return medium->mus > 0 ? 1 / medium->mus : NAN;
    return ends || mut > 0 ? -1 / cml_score_unit(mut) : NAN;
}

/* Column k of a derivative. */
static cml_status take_column(const struct cml_outcome *sums, enum cml_quantity quantity, int k, double scale,
                              struct cml_outcome *o, struct cml_error *err)
{
    const enum cml_quantity of = (enum cml_quantity)cml_quantities[quantity].sums;
    const size_t columns = (size_t)cml_outcome_bins(o, CML_AXIS_inside);
    if (!sums->value[of] || cml_outcome_size(sums, of) == 0) return CML_OK;
    CML_TRY(cml_outcome_add(o, quantity, false, err));
    CML_TRY(cml_outcome_add(o, quantity, true, err));
    for (size_t i = 0; i < cml_outcome_size(sums, of); i++) {
        o->value[quantity][i * columns + (size_t)k] = scale * sums->value[of][i] + 0.0; /* not -0 */
        o->error[quantity][i * columns + (size_t)k] = fabs(scale) * sums->error[of][i];
    }
    return CML_OK;
}

static cml_status take_score(const struct cml_report *report, int k, bool by_mus, struct cml_outcome *o,
                             struct cml_error *err)
{
    const double scale = scale_of(report, k, by_mus);
    struct cml_result result;
    struct cml_outcome sums = {.photons = o->photons,
                               .dz = o->dz,
                               .dr = o->dr,
                               .nz = o->nz,
                               .nr = o->nr,
                               .na = o->na,
                               .num_layers = o->num_layers,
                               .num_bodies = o->num_bodies,
                               .num_detectors = o->num_detectors,
                               .backed = o->backed};
    CML_TRY(cml_score_result(report->sums, 2 * k + by_mus, &result, err));
    cml_status status = cml_outcome_take(&sums, &result, err);
    for (int i = 0; status == CML_OK && i < CML_NUM_QUANTITIES; i++) {
        const enum cml_quantity quantity = (enum cml_quantity)i;
        if (cml_quantities[i].estimator == (by_mus ? CML_FROM_MUS : CML_FROM_MUA))
            status = take_column(&sums, quantity, k, scale, o, err);
    }
    sums.num_detectors = 0; /* it has none of their names */
    cml_outcome_clear(&sums);
    cml_result_free(&result);
    return status;
}

cml_status cml_report_derivatives(const struct cml_report *report, struct cml_outcome *o,
                                  struct cml_error *err)
{
    for (int score = 0; report->sums->grid.derivatives && score < report->sums->grid.rows; score++)
        CML_TRY(take_score(report, score / 2, score % 2 == 1, o, err));
    return CML_OK;
}

/* "  layer 2: dRd_dmua -0.1 +- 0.002, dTt_dmua ..." */
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
    enum { MOST = 16 }; /* the files have them all */
    const struct cml_outcome *o = &report->outcome;
    const int media = report->sums->grid.derivatives ? o->num_layers + o->num_bodies : 0;
    for (int k = 0; k < media && k < MOST; k++) print_medium(stream, o, k);
}
