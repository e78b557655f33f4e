/* SPDX-License-Identifier: MIT */
#include "exact/exact.h"

#include "base/array.h"
#include "exact/layer_response.h"
#include "exact/rough_response.h"
#include "exact/stack.h"
#include "scene/specular.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const int orders[] = {8, 11, 16, 23, 32, 45, 64, 91, 128, 181, 256, 362};

enum { NUM_ORDERS = sizeof orders / sizeof *orders, LEAST_ORDERS = 3, TERMS_PER_NODE = 2 };

/* The arguments of one call of cml_exact_solve, and its state. */
struct search {
    const struct cml_medium_def *media;
    int num_layers, count; /* number of shares */
    const struct cml_exact_light *light;
    const struct cml_exact_options *options;
    int num_rough; /* number of rough boundaries */
    /* [num_layers + 1] boundaries that send light into all directions (directions.h) */
    bool *spreads;
    /* [num_layers + 1] walks at each boundary for one order; zeroed where smooth */
    struct cml_rough_response *walked;
    struct cml_stack_rough
        rough; /* matrices chosen from `walked`: the means over all walks, or one part of the walks */
    double *history[3]; /* all shares of the last three orders, the newest first */
    double *spread;     /* [count] standard errors of the newest shares by walks, then [count] scratch */
    double defect;      /* difference between 1 and the sum of the newest shares */
    double spent;       /* work done so far, in multiplications */
    bool enough;        /* the next order would have been too much work */
};

/* Estimates the work of one order in multiplications. Nearly all of it are matrix products in power series
 * and doublings (layer_response.c). With rough boundaries layers are added up again for each part of the
 * walks. */
static double work(const struct search *search, const struct cml_directions *directions)
{
    const struct cml_medium_def *media = search->media;
    const double again = search->num_rough > 0 ? 5 * CML_ROUGH_PARTS : 0;
    double sum = 0;
    for (int m = 1; m < directions->num_media - 1; m++) {
        if (!(media[m].mus > 0)) continue;
        const int n = directions->live[m];
        const double steepest = cml_directions_cosine(directions, n - 1, media[m].n);
        const double depth = media[m].d * cml_medium_mut(&media[m]) / steepest;
        sum += pow(n, 3) * (40 + again + 7.5 * fmax(0, log2(depth)));
    }
    return sum;
}

/* True if boundary b has facets that change light. Between equal indices facets change nothing. */
static bool is_rough(const struct search *search, int b)
{
    const bool backed = b == search->num_layers && search->options->backing;
    return search->options->rough && cml_is_rough(&search->options->rough[b]) &&
           (backed || search->media[b].n != search->media[b + 1].n);
}

/* Returns the share of the incident light that the matrix R reflects. */
static double reflected_by(const double *R, const struct cml_directions *directions)
{
    const int n = directions->live[0];
    double sum = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) sum += R[i * n + j] * directions->light[j];
    return sum;
}

/* Returns the share that boundary 0 reflects at once. Parallel light at normal incidence is split as original
 * MCML does it. */
static double specular(const struct search *search, const struct cml_directions *directions)
{
    const struct cml_medium_def *media = search->media;
    const double normal = cml_exact_light_normal(search->light);
    if (is_rough(search, 0)) return reflected_by(search->rough.boundary[0].R, directions);
    double sum =
        normal * (cml_specular_split(media, media[0].n, search->num_layers, !is_rough(search, 1)).reflected -
                  cml_stack_fresnel(media[0].n, 1, media[1].n, 1));
    for (int i = 0; i < directions->live[0]; i++)
        sum += directions->light[i] *
               cml_stack_fresnel(media[0].n, cml_directions_cosine(directions, i, media[0].n), media[1].n,
                                 cml_directions_cosine(directions, i, media[1].n));
    return sum;
}

/* Computes all shares of the incident light with one order of the quadrature. search->rough holds the
 * matrices of the rough boundaries. value: [CML_EXACT_LAYERS + num_layers], indices as in enum
 * cml_exact_share. */
static cml_status solve_shares(struct search *search, const struct cml_directions *directions, int order,
                               double *value, struct cml_error *err)
{
    double *absorbed = value + CML_EXACT_LAYERS, reflected, transmitted, sum = 0;
    CML_TRY(cml_stack_shares(search->media, search->options->backing,
                             search->num_rough > 0 ? &search->rough : NULL, directions,
                             TERMS_PER_NODE * order, &reflected, &transmitted, absorbed, err));
    for (int l = 0; l < search->num_layers; l++) sum += absorbed[l];
    value[CML_EXACT_RSP] = specular(search, directions);
    value[CML_EXACT_RD] = reflected - value[CML_EXACT_RSP];
    value[CML_EXACT_A] = sum;
    value[search->options->backing ? CML_EXACT_BACKING : CML_EXACT_TT] = transmitted;
    value[search->options->backing ? CML_EXACT_TT : CML_EXACT_BACKING] = 0;
    search->defect = fabs(1 - reflected - transmitted - sum);
    if (!(search->defect < 0.01))
        return cml_fail(err, CML_E_NUMERIC, "adding-doubling loses light (numbers too large or too small?)");
    return CML_OK;
}

/* Computes standard errors of `value` from the spread over the parts of the walks. `value` is the mean over
 * these parts but for terms of second order. */
static cml_status find_spread(struct search *search, const struct cml_directions *directions, int order,
                              const double *value, struct cml_error *err)
{
    const int count = search->count;
    double *part = search->spread + count;
    memset(search->spread, 0, (size_t)count * sizeof *search->spread);
    for (int k = 0; k < CML_ROUGH_PARTS && search->num_rough > 0; k++) {
        for (int b = 0; b <= search->num_layers; b++) search->rough.boundary[b] = search->walked[b].part[k];
        CML_TRY(solve_shares(search, directions, order, part, err));
        for (int i = 0; i < count; i++) search->spread[i] += (part[i] - value[i]) * (part[i] - value[i]);
    }
    for (int i = 0; i < count; i++)
        search->spread[i] = sqrt(search->spread[i] / CML_ROUGH_PARTS / (CML_ROUGH_PARTS - 1));
    return CML_OK;
}

/* Computes all totals with one number of directions (order) and keeps them as the newest of the last three
 * orders, from which errors are estimated. find_spread solves again for each part of the walks, so the
 * energy defect of the mean is put back afterwards. */
static cml_status solve_order(struct search *search, const struct cml_directions *directions, int order,
                              struct cml_error *err)
{
    double *value = search->history[2];
    for (int b = 0; b <= search->num_layers; b++) search->rough.boundary[b] = search->walked[b].mean;
    CML_TRY(solve_shares(search, directions, order, value, err));
    const double defect = search->defect;
    CML_TRY(find_spread(search, directions, order, value, err));
    search->defect = defect;
    search->history[2] = search->history[1];
    search->history[1] = search->history[0];
    search->history[0] = value;
    return CML_OK;
}

/* Computes the response of every rough boundary by random walks. lit: light in a beam's own direction
 * reaches only the uppermost rough boundary. */
static cml_status walk_boundaries(struct search *search, const struct cml_directions *directions, int order,
                                  struct cml_error *err)
{
    bool lit = true;
    for (int b = 0; b <= search->num_layers; b++) {
        if (!is_rough(search, b)) continue;
        const bool backed = b == search->num_layers && search->options->backing;
        const struct cml_rough_plane plane = {search->options->rough[b], search->media[b].n,
                                              search->media[b + 1].n,
                                              backed ? search->options->backing : NULL, lit};
        CML_TRY(cml_rough_response_create(&plane, directions, directions->live[b],
                                          backed ? 0 : directions->live[b + 1], search->options->walks,
                                          (unsigned)order + 512u * (unsigned)b, &search->walked[b], err));
        lit = false;
    }
    return CML_OK;
}

/* Computes the shares with one order of the quadrature. Sets search->enough, and computes nothing, if the
 * work of all orders would exceed options->most_work. */
static cml_status raise_order(struct search *search, int order, struct cml_error *err)
{
    CML_AT_END(cml_directions_clear) struct cml_directions directions = {0};
    CML_TRY(cml_directions_create(search->media, search->num_layers, search->spreads, search->light, order,
                                  &directions, err));
    search->spent += work(search, &directions);
    search->enough = search->spent > search->options->most_work;
    if (search->enough) return CML_OK;
    cml_status status = walk_boundaries(search, &directions, order, err);
    if (status == CML_OK) status = solve_order(search, &directions, order, err);
    for (int b = 0; b <= search->num_layers; b++) {
        cml_rough_response_clear(&search->walked[b]);
        cml_layer_response_clear(&search->rough.layer[b]);
    }
    return status;
}

/* Returns the weight of a share's error: by how much a share exp(-depth) changes per relative change of its
 * optical depth, plus the share itself. The error of a large share then counts absolutely, and the error of a
 * small share nearly relatively. */
static double weight_of(double share)
{
    return share > 0 && share < 1 ? share * (1 - log(share)) : share > 0;
}

/* Estimates the error of each share. An error is twice the larger of two changes: the change of this share
 * from the two earlier orders, and a tenth of the largest change of any share, because a single change may be
 * small by chance. The factor of two allows for slow convergence. With walks the error is at least four
 * standard errors. The loss of the sum of shares, and rounding, are added. Returns true if the orders differ
 * by no more than the noise of the walks. */
static bool estimate(const struct search *search, struct cml_exact *exact)
{
    double *const *history = search->history, most = 0, most_spread = 0;
    for (int i = 0; i < exact->count; i++) {
        const double value = history[0][i];
        exact->value[i] = value;
        exact->error[i] = fmax(fabs(value - history[1][i]), fabs(value - history[2][i]));
        most = fmax(most, exact->error[i]);
        most_spread = fmax(most_spread, search->spread[i]);
    }
    for (int i = 0; i < exact->count; i++) {
        const double weight = weight_of(exact->value[i]);
        exact->error[i] = fmax(2 * fmax(exact->error[i], 0.1 * most * weight), 4 * search->spread[i]) +
                          (search->defect + DBL_EPSILON) * weight + CML_LEAST_THROUGH;
    }
    exact->error[CML_EXACT_RD] += DBL_EPSILON;
    const bool spread = search->light->diffuse > 0 || search->light->num_samples > 0;
    if (!spread && !is_rough(search, 0)) exact->error[CML_EXACT_RSP] = DBL_EPSILON;
    return search->num_rough > 0 && most <= 2 * most_spread;
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

/* Estimates the work of the first LEAST_ORDERS orders, without which there is no estimate of errors. Sets
 * search->enough if that is already too much, before any of the work is done. */
static cml_status look_ahead(struct search *search, struct cml_error *err)
{
    double sum = 0;
    for (int k = 0; k < LEAST_ORDERS; k++) {
        CML_AT_END(cml_directions_clear) struct cml_directions directions = {0};
        CML_TRY(cml_directions_create(search->media, search->num_layers, search->spreads, search->light,
                                      orders[k], &directions, err));
        sum += work(search, &directions);
    }
    search->enough = sum > search->options->most_work;
    return CML_OK;
}

/* Computes the totals with more and more directions (orders) until all errors are within the tolerance, or
 * the work is too much. */
static cml_status converge(struct search *search, struct cml_exact *exact, struct cml_error *err)
{
    CML_TRY(look_ahead(search, err));
    for (int k = 0; !search->enough && k < NUM_ORDERS && !exact->converged; k++) {
        CML_TRY(raise_order(search, orders[k], err));
        if (search->enough) break;
        if (k < LEAST_ORDERS - 1) continue;
        const bool settled = estimate(search, exact);
        exact->order = orders[k];
        exact->converged = settled || cml_exact_worst(exact) <= search->options->tolerance;
    }
    if (exact->order > 0) return CML_OK;
    return cml_fail(err, CML_E_NUMERIC, "adding-doubling takes more than %g multiplications",
                    search->options->most_work);
}

/* Allocates what the search for converged totals needs: the totals of the last three orders, and the spread
 * of walks at rough boundaries. */
static cml_status allocate(struct cml_arrays *arrays, struct search *search, struct cml_error *err)
{
    const size_t boundaries = (size_t)search->num_layers + 1, count = (size_t)search->count;
    for (int i = 0; i < 3; i++) search->history[i] = cml_arrays_add(arrays, count, sizeof(double));
    search->spread = cml_arrays_add(arrays, 2 * count, sizeof(double));
    search->spreads = cml_arrays_add(arrays, boundaries, sizeof *search->spreads);
    search->walked = cml_arrays_add(arrays, boundaries, sizeof *search->walked);
    search->rough.boundary = cml_arrays_add(arrays, boundaries, sizeof *search->rough.boundary);
    search->rough.layer = cml_arrays_add(arrays, boundaries, sizeof *search->rough.layer);
    return cml_arrays_check(arrays, "totals", err);
}

/* Finds the boundaries that are rough, and those that send light into all directions. */
static void find_rough(struct search *search)
{
    const struct cml_backing_def *backing = search->options->backing;
    search->spreads[search->num_layers] = backing && backing->kind == CML_BACKING_LAMBERTIAN;
    for (int b = 0; b <= search->num_layers; b++) {
        search->num_rough += is_rough(search, b);
        search->spreads[b] |= is_rough(search, b);
    }
}

cml_status cml_exact_solve(const struct cml_medium_def *media, int num_layers,
                           const struct cml_exact_light *light, const struct cml_exact_options *options,
                           struct cml_exact *exact, struct cml_error *err)
{
    struct search search = {.media = media,
                            .num_layers = num_layers,
                            .count = CML_EXACT_LAYERS + num_layers,
                            .light = light,
                            .options = options};
    struct cml_arrays arrays = {0};
    *exact = (struct cml_exact){.count = search.count};
    exact->value = calloc((size_t)search.count, sizeof *exact->value);
    exact->error = calloc((size_t)search.count, sizeof *exact->error);
    cml_status status = exact->value && exact->error ? allocate(&arrays, &search, err)
                                                     : cml_fail_memory(err, 16.0 * search.count, "totals");
    if (status == CML_OK) {
        find_rough(&search);
        exact->walks = search.num_rough > 0 ? options->walks : 0;
        status = converge(&search, exact, err);
    }
    cml_arrays_free(&arrays);
    if (status != CML_OK) cml_exact_clear(exact);
    return status;
}

cml_status cml_exact_scene(const struct cml_scene *scene, const double *depth,
                           const struct cml_exact_options *options, struct cml_exact *exact,
                           struct cml_error *err)
{
    const size_t count = (size_t)scene->num_layers + 2;
    CML_AT_END(cml_exact_light_clear) struct cml_exact_light light = {0};
    if (scene->num_bodies > 0)
        return cml_fail_field(err, scene->file, scene->bodies[0].line, "body 1", "i",
                              "layers without bodies: adding-doubling knows no others");
    if (scene->num_contacts > 0)
        return cml_fail(
            err, CML_E_INPUT,
            "%s:%d: boundary 0 has a face (expected one index above all of it: adding-doubling knows "
            "no face or port lines)",
            scene->file, scene->contacts->line);
    if (scene->backing.kind == CML_BACKING_METAL)
        return cml_fail_field(err, scene->file, scene->backing.line, "backing", "metal",
                              "mirror or lambertian: adding-doubling knows no others");
    struct cml_exact_options own = *options;
    own.backing = scene->backing.kind == CML_BACKING_NONE ? NULL : &scene->backing;
    CML_FREED struct cml_medium_def *media = malloc(count * sizeof *media);
    CML_FREED struct cml_rough_def *rough = malloc(count * sizeof *rough);
    if (!media || !rough) return cml_fail_memory(err, (double)(count * sizeof *media), "media");
    CML_TRY(cml_exact_light_create(scene, depth ? depth[0] : 0, &light, err));
    for (int b = 0; b <= scene->num_layers; b++) rough[b] = scene->boundaries[b].rough;
    own.rough = rough;
    memcpy(media, scene->media, count * sizeof *media);
    for (int l = 1; depth && l <= scene->num_layers; l++) media[l].d = depth[l] - depth[l - 1];
    const cml_status status = cml_exact_solve(media, scene->num_layers, &light, &own, exact, err);
    if (status != CML_E_NUMERIC) return status;
    char reason[128];
    snprintf(reason, sizeof reason, "%.127s", err->text);
    return cml_fail(err, status, "%s:%d: %s", scene->file, scene->line, reason);
}
