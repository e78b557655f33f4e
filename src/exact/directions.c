/* SPDX-License-Identifier: MIT */
#include "exact/directions.h"

#include "base/constants.h"

#include <math.h>
#include <stdlib.h>

/* Returns the Legendre polynomial P_n(x) by its recurrence, and its derivative in *slope; -1 < x < 1. */
static double legendre(int n, double x, double *slope)
{
    double before = 1, p = x;
    for (int l = 2; l <= n; l++) {
        const double next = ((2 * l - 1) * x * p - (l - 1) * before) / l;
        before = p;
        p = next;
    }
    *slope = n * (before - x * p) / (1 - x * x);
    return p;
}

/* Newton's method from Tricomi's first guess. */
double cml_gauss_node(int n, int i, double *weight)
{
    double x = cos(CML_PI * (i + 0.75) / (n + 0.5)), slope = 1;
    for (int step = 0; step < 8; step++) x -= legendre(n, x, &slope) / slope;
    legendre(n, x, &slope);
    *weight = 2 / ((1 - x * x) * slope * slope);
    return x;
}

/* Fills `index` with the different indices of the media, rising. Returns their number. */
static int sort_indices(const struct cml_medium_def *media, int count, double *index)
{
    for (int m = 0; m < count; m++) index[m] = media[m].n;
    return (int)cml_sort_distinct(index, (size_t)count);
}

/* Returns the cosine, in a medium of index n, of the direction with the cosine c in a medium of index n1; 0:
 * total reflection. Written so that no digits cancel if the indices are nearly equal. */
static double refracted_cosine(double n1, double c, double n)
{
    const double square = (n - n1) * (n + n1) + n1 * c * (n1 * c);
    return square > 0 ? sqrt(square) / n : 0;
}

/* Returns the number of nodes in the interval of s between two indices. It is proportional to the interval's
 * part of a quarter circle, plus a few: in a narrow interval light is a smooth function, but not a polynomial
 * of low degree. */
static int interval_nodes(double below, double above, int order)
{
    const double part = acos(below / above) / (CML_PI / 2);
    return 3 + order / 8 + (int)ceil((order - 3 - order / 8) * part);
}

/* Adds a direction; one with etendue is also added to the list of directions with weight. */
static void add_direction(struct cml_directions *to, double index, double cosine, double etendue)
{
    to->index[to->count] = index;
    to->cosine[to->count] = cosine;
    to->etendue[to->count] = etendue;
    if (etendue > 0) to->weighted[to->num_weighted++] = to->count;
    to->count++;
}

/* Adds the nodes of an interval. s^2 = above^2 (1 - cosine^2), so s ds = above^2 cosine d(cosine). */
static void add_interval(struct cml_directions *to, double below, double above, int nodes)
{
    const double most = sqrt((above - below) * (above + below)) / above;
    for (int i = 0; i < nodes; i++) {
        double weight;
        const double cosine = most * 0.5 * (1 + cml_gauss_node(nodes, i, &weight));
        add_direction(to, above, cosine, above * above * cosine * weight * most * 0.5);
    }
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* Returns the number of directions that stand for light with spread directions in one interval between
 * indices. */
static int gathered_nodes(int order)
{
    return least(8 + order / 4, 64);
}

/* Adds directions that stand for light spread over many directions, such as a cone. The light between the
 * critical angles of two indices (below, above) is moved to a few fixed directions, because all its effects
 * are smooth functions of the cosine. x, gathered: scratch. */
static void add_gathered(struct cml_directions *to, const struct cml_exact_light *light, double n0,
                         double below, double above, int order, double *x, struct cml_exact_ray *gathered)
{
    const int count = gathered_nodes(order);
    double low = 1, high = 0;
    int inside = 0;
    for (int k = 0; k < light->num_samples; k++) {
        const struct cml_exact_ray ray = light->sample[k];
        const double cosine = refracted_cosine(n0, ray.cosine, above);
        if (!(cosine > 0) || (below > 0 && refracted_cosine(n0, ray.cosine, below) > 0)) continue;
        x[inside] = cosine;
        gathered[inside++] = ray;
        low = fmin(low, cosine);
        high = fmax(high, cosine);
    }
    if (inside == 0) return;
    cml_exact_gather(x, gathered, inside, low, high, count, to->light + to->count);
    for (int i = 0; i < count; i++) add_direction(to, above, cml_exact_node(low, high, count, i), 0);
}

/* Adds all directions of a stack, interval by interval: those of beams, those of spread light, and the nodes
 * of the quadrature. An interval lies between the critical angles of two neighbouring indices. */
static void add_all(struct cml_directions *to, const double *index, int distinct, double n0,
                    const struct cml_exact_light *light, int order, double *x, struct cml_exact_ray *gathered)
{
    double below = 0;
    int beam = 0;
    for (int k = 0; k < distinct; k++) {
        for (; beam < light->num_beams && refracted_cosine(n0, light->beam[beam].cosine, index[k]) > 0;
             beam++) {
            to->light[to->count] = light->beam[beam].share;
            add_direction(to, n0, light->beam[beam].cosine, 0);
        }
        if (light->num_samples > 0 && below < n0)
            add_gathered(to, light, n0, below, index[k], order, x, gathered);
        add_interval(to, below, index[k], interval_nodes(below, index[k], order));
        below = index[k];
    }
}

double cml_directions_cosine(const struct cml_directions *directions, int i, double n)
{
    return refracted_cosine(directions->index[i], directions->cosine[i], n);
}

struct cml_dense_kind cml_directions_kind(const struct cml_directions *directions, int n)
{
    int full = 0;
    while (full < directions->num_weighted && directions->weighted[full] < n) full++;
    return (struct cml_dense_kind){n, full, directions->weighted};
}

/* Returns the number of directions that exist in a medium of index n, by bisection. Directions that exist at
 * a lower index come first. */
static int count_directions(const struct cml_directions *directions, double n)
{
    int low = 0, high = directions->count;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (cml_directions_cosine(directions, middle, n) > 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* True if a layer scatters enough light into other directions to count. Scattering exactly forwards or
 * backwards changes no direction. */
static bool scatters(const struct cml_medium_def *medium)
{
    return medium->mus * medium->d * (medium->phase ? 1 : 1 - fabs(medium->g)) > 1e-12;
}

static int greatest(int a, int b)
{
    return a > b ? a : b;
}

/* Finds in which directions each medium contains light. Light comes from outside, from scattering, from a
 * neighbour, or from a boundary that spreads light. One pass downwards and one upwards are enough, because
 * light that turns around keeps the directions that it had on its way. A clear layer that reflects totally on
 * both sides would hold light for ever, but none gets in. */
static void find_live(const struct cml_medium_def *media, const bool *spreads, struct cml_directions *to)
{
    const int last = to->num_media - 1;
    int *live = to->live;
    for (int m = 0; m <= last; m++) {
        const int all = count_directions(to, media[m].n);
        const bool fed = spreads && ((m > 0 && spreads[m - 1]) || (m < last && spreads[m]));
        live[m] = m == 0 || scatters(&media[m]) || fed ? all : least(live[m - 1], all);
    }
    for (int m = last - 1; m > 0; m--)
        live[m] = greatest(live[m], least(live[m + 1], count_directions(to, media[m].n)));
}

/* Adds diffuse light: each direction of medium 0 gets a share in proportion to its etendue. */
static void add_diffuse(struct cml_directions *to, double share, double n0)
{
    for (int i = 0; i < to->live[0]; i++) to->light[i] += share * 2 * to->etendue[i] / (n0 * n0);
}

void cml_directions_clear(struct cml_directions *directions)
{
    cml_arrays_free(&directions->arrays);
    *directions = (struct cml_directions){0};
}

/* Allocates the tables of directions for `most` directions at most. */
static cml_status allocate(int most, struct cml_directions *to, struct cml_error *err)
{
    to->index = cml_arrays_add(&to->arrays, (size_t)most, sizeof *to->index);
    to->cosine = cml_arrays_add(&to->arrays, (size_t)most, sizeof *to->cosine);
    to->etendue = cml_arrays_add(&to->arrays, (size_t)most, sizeof *to->etendue);
    to->light = cml_arrays_add(&to->arrays, (size_t)most, sizeof *to->light);
    to->live = cml_arrays_add(&to->arrays, (size_t)to->num_media, sizeof *to->live);
    to->weighted = cml_arrays_add(&to->arrays, (size_t)most, sizeof *to->weighted);
    return cml_arrays_check(&to->arrays, "directions", err);
}

cml_status cml_directions_create(const struct cml_medium_def *media, int num_layers, const bool *spreads,
                                 const struct cml_exact_light *light, int order, struct cml_directions *to,
                                 struct cml_error *err)
{
    const int num_media = num_layers + 2;
    CML_AT_END(cml_arrays_free) struct cml_arrays arrays = {0};
    double *index = cml_arrays_add(&arrays, (size_t)num_media, sizeof *index),
           *x = cml_arrays_add(&arrays, (size_t)light->num_samples, sizeof *x);
    struct cml_exact_ray *gathered = cml_arrays_add(&arrays, (size_t)light->num_samples, sizeof *gathered);
    *to = (struct cml_directions){.num_media = num_media};
    CML_TRY(cml_arrays_check(&arrays, "directions", err));
    const int distinct = sort_indices(media, num_media, index);
    int most = light->num_beams;
    for (int k = 0; k < distinct; k++) most += interval_nodes(k > 0 ? index[k - 1] : 0, index[k], order);
    if (light->num_samples > 0) most += distinct * gathered_nodes(order);
    CML_TRY(allocate(most, to, err));
    add_all(to, index, distinct, media[0].n, light, order, x, gathered);
    find_live(media, spreads, to);
    if (light->diffuse > 0) add_diffuse(to, light->diffuse, media[0].n);
    return CML_OK;
}
