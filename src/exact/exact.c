/* SPDX-License-Identifier: MIT */
#include "exact/exact.h"

#include "exact/layer_response.h"
#include "exact/stack.h"
#include "scene/specular.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const int orders[] = {8, 11, 16, 23, 32, 45, 64, 91, 128, 181, 256, 362};

enum { NUM_ORDERS = sizeof orders / sizeof *orders, LEAST_ORDERS = 3, TERMS_PER_NODE = 2 };

/* Products of matrices in power series and doublings are nearly all of it (layer_response.c). */
static double work(const struct cml_medium_def *media, const struct cml_directions *directions)
{
    double sum = 0;
    for (int m = 1; m < directions->num_media - 1; m++) {
        if (!(media[m].mus > 0)) continue;
        const int n = directions->live[m];
        const double steepest = cml_directions_cosine(directions, n - 1, media[m].n);
        const double depth = media[m].d * cml_medium_mut(&media[m]) / steepest;
        sum += pow(n, 3) * (40 + 7.5 * fmax(0, log2(depth)));
    }
    return sum;
}

/* One call's question, and how far it has come. */
struct search {
    const struct cml_medium_def *media;
    int num_layers;
    const struct cml_exact_light *light;
    const struct cml_exact_options *options;
    double *history[3]; /* all shares, of the newest order first */
    double defect;      /* what those of the newest order lack of 1 */
    double spent;       /* work */
    bool enough;        /* the next order was too much work */
};

/* What comes back from boundary 0 at once; of parallel light at normal incidence as original MCML splits it.
 */
static double specular(const struct search *search, const struct cml_directions *directions)
{
    const struct cml_medium_def *media = search->media;
    const double normal = cml_exact_light_normal(search->light);
    double sum = normal * (cml_specular_split(media, search->num_layers, true).reflected -
                           cml_stack_fresnel(media[0].n, 1, media[1].n, 1));
    for (int i = 0; i < directions->live[0]; i++)
        sum += directions->light[i] *
               cml_stack_fresnel(media[0].n, cml_directions_cosine(directions, i, media[0].n), media[1].n,
                                 cml_directions_cosine(directions, i, media[1].n));
    return sum;
}

/* All shares of one order become the newest; those of three orders before go. */
static cml_status solve_order(struct search *search, const struct cml_directions *directions, int order,
                              struct cml_error *err)
{
    double *value = search->history[2], *absorbed = value + CML_EXACT_LAYERS, reflected, transmitted, sum = 0;
    CML_TRY(cml_stack_shares(search->media, search->options->backing, directions, TERMS_PER_NODE * order,
                             &reflected, &transmitted, absorbed, err));
    for (int l = 0; l < search->num_layers; l++) sum += absorbed[l];
    value[CML_EXACT_RSP] = specular(search, directions);
    value[CML_EXACT_RD] = reflected - value[CML_EXACT_RSP];
    value[CML_EXACT_A] = sum;
    value[search->options->backing ? CML_EXACT_BACKING : CML_EXACT_TT] = transmitted;
    value[search->options->backing ? CML_EXACT_TT : CML_EXACT_BACKING] = 0;
    search->defect = fabs(1 - reflected - transmitted - sum);
    if (!(search->defect < 0.01))
        return cml_fail(err, CML_E_NUMERIC, "adding-doubling loses light (numbers too large or too small?)");
    search->history[2] = search->history[1];
    search->history[1] = search->history[0];
    search->history[0] = value;
    return CML_OK;
}

static bool is_diffuse(const struct cml_backing_def *backing)
{
    return backing && backing->kind == CML_BACKING_LAMBERTIAN;
}

static cml_status raise_order(struct search *search, int order, struct cml_error *err)
{
    struct cml_directions directions;
    CML_TRY(cml_directions_create(search->media, search->num_layers, is_diffuse(search->options->backing),
                                  search->light, order, &directions, err));
    search->spent += work(search->media, &directions);
    search->enough = search->spent > search->options->most_work;
    const cml_status status = search->enough ? CML_OK : solve_order(search, &directions, order, err);
    cml_directions_clear(&directions);
    return status;
}

/* By how much a share changes where what its logarithm is made of, depths in mean free paths, changes by 1:
 * of a large share an absolute error, of a small one nearly a relative one. */
static double weight_of(double share)
{
    return share > 0 && share < 1 ? share * (1 - log(share)) : share > 0;
}

/* Changes of two orders, and a tenth of what other shares change, because one may be small by chance; twice
 * of them, because they may become smaller slowly. The last terms are the rounding of a sum of shares, and of
 * Rd's difference. */
static void estimate(const struct search *search, struct cml_exact *exact)
{
    double *const *history = search->history, most = 0;
    for (int i = 0; i < exact->count; i++) {
        const double value = history[0][i];
        exact->value[i] = value;
        exact->error[i] = fmax(fabs(value - history[1][i]), fabs(value - history[2][i]));
        most = fmax(most, exact->error[i]);
    }
    for (int i = 0; i < exact->count; i++) {
        const double weight = weight_of(exact->value[i]);
        exact->error[i] = 2 * fmax(exact->error[i], 0.1 * most * weight) +
                          (search->defect + DBL_EPSILON) * weight + CML_LEAST_THROUGH;
    }
    exact->error[CML_EXACT_RD] += DBL_EPSILON;
    const bool spread = search->light->diffuse > 0 || search->light->num_samples > 0;
    exact->error[CML_EXACT_RSP] = spread ? exact->error[CML_EXACT_RSP] : DBL_EPSILON;
}

double cml_exact_worst(const struct cml_exact *exact)
{
    double worst = 0;
    for (int i = 0; i < exact->count; i++) worst = fmax(worst, exact->error[i]);
    return worst;
}

void cml_exact_clear(struct cml_exact *exact)
{
    free(exact->value);
    free(exact->error);
    *exact = (struct cml_exact){0};
}

/* Whether the orders without which there is no estimate are too much work, before any of it is done. */
static cml_status look_ahead(struct search *search, struct cml_error *err)
{
    double sum = 0;
    for (int k = 0; k < LEAST_ORDERS; k++) {
        struct cml_directions directions;
        CML_TRY(cml_directions_create(search->media, search->num_layers, is_diffuse(search->options->backing),
                                      search->light, orders[k], &directions, err));
        sum += work(search->media, &directions);
        cml_directions_clear(&directions);
    }
    search->enough = sum > search->options->most_work;
    return CML_OK;
}

static cml_status converge(struct search *search, struct cml_exact *exact, struct cml_error *err)
{
    CML_TRY(look_ahead(search, err));
    for (int k = 0; !search->enough && k < NUM_ORDERS && !exact->converged; k++) {
        CML_TRY(raise_order(search, orders[k], err));
        if (search->enough) break;
        if (k < LEAST_ORDERS - 1) continue;
        estimate(search, exact);
        exact->order = orders[k];
        exact->converged = cml_exact_worst(exact) <= search->options->tolerance;
    }
    if (exact->order > 0) return CML_OK;
    return cml_fail(err, CML_E_NUMERIC, "adding-doubling takes more than %g multiplications",
                    search->options->most_work);
}

cml_status cml_exact_solve(const struct cml_medium_def *media, int num_layers,
                           const struct cml_exact_light *light, const struct cml_exact_options *options,
                           struct cml_exact *exact, struct cml_error *err)
{
    const size_t count = (size_t)CML_EXACT_LAYERS + (size_t)num_layers;
    double *numbers = calloc(3 * count, sizeof *numbers);
    struct search search = {.media = media, .num_layers = num_layers, .light = light, .options = options};
    for (size_t i = 0; numbers && i < 3; i++) search.history[i] = numbers + i * count;
    *exact = (struct cml_exact){.count = (int)count};
    exact->value = calloc(count, sizeof *exact->value);
    exact->error = calloc(count, sizeof *exact->error);
    const cml_status status = numbers && exact->value && exact->error
                                  ? converge(&search, exact, err)
                                  : cml_fail_memory(err, 40.0 * (double)count, "totals");
    free(numbers);
    if (status != CML_OK) cml_exact_clear(exact);
    return status;
}

cml_status cml_exact_scene(const struct cml_scene *scene, const double *depth,
                           const struct cml_exact_options *options, struct cml_exact *exact,
                           struct cml_error *err)
{
    const size_t count = (size_t)scene->num_layers + 2;
    struct cml_exact_light light;
    if (scene->num_bodies > 0)
        return cml_fail_field(err, scene->file, scene->bodies[0].line, "body 1", "i",
                              "layers without bodies: adding-doubling knows no others");
    if (scene->backing.kind == CML_BACKING_METAL)
        return cml_fail_field(err, scene->file, scene->backing.line, "backing", "metal",
                              "mirror or lambertian: adding-doubling knows no others");
    int b;
    const struct cml_rough_def *rough = cml_scene_rough(scene, &b);
    char owner[32];
    snprintf(owner, sizeof owner, "boundary %d", b);
    if (rough)
        return cml_fail_field(err, scene->file, rough->line, owner, "rough",
                              "smooth boundaries: adding-doubling knows no others");
    struct cml_exact_options own = *options;
    own.backing = scene->backing.kind == CML_BACKING_NONE ? NULL : &scene->backing;
    struct cml_medium_def *media = malloc(count * sizeof *media);
    if (!media) return cml_fail_memory(err, (double)(count * sizeof *media), "media");
    cml_status status = cml_exact_light_create(scene, depth ? depth[0] : 0, &light, err);
    if (status != CML_OK) {
        free(media);
        return status;
    }
    memcpy(media, scene->media, count * sizeof *media);
    for (int l = 1; depth && l <= scene->num_layers; l++) media[l].d = depth[l] - depth[l - 1];
    status = cml_exact_solve(media, scene->num_layers, &light, &own, exact, err);
    cml_exact_light_clear(&light);
    free(media);
    if (status != CML_E_NUMERIC) return status;
    char reason[128];
    snprintf(reason, sizeof reason, "%.127s", err->text);
    return cml_fail(err, status, "%s:%d: %s", scene->file, scene->line, reason);
}
