/* Makes the table of expected values. Between two indices the response is a smooth function of the cosine c
 * in a medium of the upper index. Grazing light is the exception, where the response goes with c ln c
 * [Chandrasekhar, Radiative Transfer, 1960, chapter 5: H(c) has it]. As a function of the square root of c
 * the response is smooth enough for few Chebyshev nodes. SPDX-License-Identifier: MIT */
#include "exact/tail_response.h"

#include "base/array.h"
#include "base/constants.h"
#include "exact/stack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const int orders[] = {32, 45, 64, 91, 128};

enum { NUM_ORDERS = sizeof orders / sizeof *orders, TERMS_PER_NODE = 2, MOST_DIRECTIONS = 640 };

/* Largest relative change of a response between the last two orders. The table is then accurate enough,
 * because the next change would be much smaller. */
#define CHANGE 2e-5

/* Returns the number of nodes in an interval of the table. */
static int nodes_of(const struct cml_flat_tail *tail, int interval)
{
    const double share = interval > 0 ? tail->index[interval - 1] / tail->index[interval] : 0;
    return 12 + (int)ceil(24 * acos(share) / (CML_PI / 2));
}

/* Fills tail->index with the different refractive indices from the level's medium down. Leaves out indices
 * larger than the index of the level's medium. */
static void find_intervals(const struct cml_medium_def *media, int count, struct cml_flat_tail *tail)
{
    for (int m = 0; m < count; m++)
        if (media[m].n <= media[0].n) tail->index[tail->intervals++] = media[m].n;
    tail->intervals = (int)cml_sort_distinct(tail->index, (size_t)tail->intervals);
}

/* Makes the rays for which responses are computed: at all nodes, with falling cosines in the level's medium.
 * Returns their number. */
static int set_rays(const struct cml_flat_tail *tail, struct cml_exact_ray *ray)
{
    const double n = tail->index[tail->intervals - 1];
    int count = 0;
    for (int k = 0; k < tail->intervals; k++) {
        const double nk = tail->index[k], widest = cml_flat_tail_widest(tail, k);
        for (int i = 0; i < nodes_of(tail, k); i++) {
            const double root = cml_exact_node(0, widest, nodes_of(tail, k), i), across = nk * root * root;
            ray[count++].cosine = sqrt((n - nk) * (n + nk) + across * across) / n;
        }
    }
    return count;
}

/* Computes the responses of one order, response: [1 + num_layers][count]. stack: the medium above the level,
 * the layers, and the medium below. */
static cml_status solve(const struct cml_medium_def *stack, int num_layers,
                        const struct cml_exact_light *light, int order, double *response,
                        struct cml_error *err)
{
    CML_AT_END(cml_directions_clear) struct cml_directions directions = {0};
    CML_TRY(cml_directions_create(stack, num_layers, NULL, light, order, &directions, err));
    if (directions.count > MOST_DIRECTIONS)
        return cml_fail(err, CML_E_NUMERIC, "adding-doubling takes more than %d directions", MOST_DIRECTIONS);
    return cml_stack_responses(stack, &directions, TERMS_PER_NODE * order, light->num_beams, response, err);
}

/* Returns the largest relative change from old to new responses, by which the search for enough directions
 * ends. Responses below a thousandth of the largest in their row are compared with that thousandth. Grazing
 * light counts less, because little arrives: by 30 c^2 at a cosine c. */
static double largest_change(const struct cml_flat_tail *tail, const double *old, const double *new, int rows,
                             int count)
{
    double change = 0;
    for (int r = 0; r < rows; r++, old += count, new += count) {
        double most = 0;
        for (int i = 0; i < count; i++) most = fmax(most, new[i]);
        for (int k = 0, first = 0; most > 0 && k < tail->intervals; first += nodes_of(tail, k++))
            for (int i = 0; i < nodes_of(tail, k); i++) {
                const double root = cml_exact_node(0, cml_flat_tail_widest(tail, k), nodes_of(tail, k), i),
                             relative =
                                 fabs(new[first + i] - old[first + i]) / fmax(new[first + i], 1e-3 * most);
                change = fmax(change, relative * fmin(1, 30 * root * root));
            }
    }
    return change;
}

/* Computes the responses of all rays with more and more directions until they change by less than CHANGE. */
static cml_status converge(const struct cml_medium_def *stack, int num_layers,
                           const struct cml_flat_tail *tail, const struct cml_exact_light *light,
                           double *response, struct cml_error *err)
{
    const size_t size = ((size_t)num_layers + 1) * (size_t)light->num_beams;
    CML_FREED double *before = calloc(size, sizeof *before);
    double change = INFINITY;
    if (!before) return cml_fail_memory(err, (double)size * sizeof *before, "responses");
    for (int k = 0; k < NUM_ORDERS; k++) {
        memcpy(before, response, size * sizeof *before);
        CML_TRY(solve(stack, num_layers, light, orders[k], response, err));
        if (k > 0) change = largest_change(tail, before, response, num_layers + 1, light->num_beams);
        if (change < CHANGE) return CML_OK;
    }
    return cml_fail(err, CML_E_NUMERIC, "adding-doubling: responses change by %.1g at order %d", change,
                    orders[NUM_ORDERS - 1]);
}

/* Fills the table of one interval of directions by interpolation from the responses at its nodes, which
 * begin at number `first` among `count` rays. response: [1 + layers][count]. */
static void fill_interval(const struct cml_flat_tail *tail, int interval, const double *response, int first,
                          int count, double *table)
{
    const int nodes = nodes_of(tail, interval), scores = tail->scores;
    const double widest = cml_flat_tail_widest(tail, interval);
    const struct cml_exact_ray one = {0, 1};
    for (int j = 0; j <= CML_FLAT_TAIL_CELLS; j++) {
        const double root = widest * j / CML_FLAT_TAIL_CELLS;
        double share[64] = {0};
        cml_exact_gather(&root, &one, 1, 0, widest, nodes, share);
        for (int s = 0; s < scores; s++) {
            const double *node =
                /* Row 1 belongs to the level's own layer, which has no score. */
                response + (s == 0 ? 0 : s + 1) * count + first;
            double sum = 0;
            for (int i = 0; i < nodes; i++) sum += share[i] * node[i];
            table[j * scores + s] = fmax(sum, 0);
        }
    }
}

/* Scales each score of the table by a power of two to at most 1, and converts it to single precision. */
static void scale(struct cml_flat_tail *tail, const double *table)
{
    const int cells = tail->intervals * (CML_FLAT_TAIL_CELLS + 1);
    for (int s = 0; s < tail->scores; s++) {
        double most = 0;
        int power = 0;
        for (int j = 0; j < cells; j++) most = fmax(most, table[j * tail->scores + s]);
        if (most < CML_TAIL_LEAST) continue;
        (void)frexp(most, &power);
        tail->exponent[s] = power >= 0                        ? 0
                            : -power < CML_TAIL_MOST_EXPONENT ? -power
                                                              : CML_TAIL_MOST_EXPONENT;
        for (int j = 0; j < cells; j++)
            tail->response[j * tail->scores + s] =
                (float)fmin(ldexp(table[j * tail->scores + s], tail->exponent[s]), 1);
    }
}

/* Makes the table that replaces the flight below a level in flat layers: computes exact responses for some
 * directions of light, interpolates the table's cells from them and scales it. */
static cml_status fill(const struct cml_medium_def *stack, int num_layers, struct cml_flat_tail *tail,
                       struct cml_error *err)
{
    const size_t numbers = (size_t)tail->intervals * (CML_FLAT_TAIL_CELLS + 1) * (size_t)tail->scores,
                 most = 64 * (size_t)tail->intervals;
    CML_AT_END(cml_arrays_free) struct cml_arrays arrays = {0};
    struct cml_exact_light light = {.beam = cml_arrays_add(&arrays, most, sizeof *light.beam)};
    double *table = cml_arrays_add(&arrays, numbers, sizeof *table),
           *response = cml_arrays_add(&arrays, most * ((size_t)num_layers + 1), sizeof *response);
    tail->response = calloc(numbers, sizeof *tail->response);
    arrays.failed |= !tail->response;
    CML_TRY(cml_arrays_check(&arrays, "the layers below a level", err));
    light.num_beams = set_rays(tail, light.beam);
    CML_TRY(converge(stack, num_layers, tail, &light, response, err));
    for (int k = 0, first = 0; k < tail->intervals; first += nodes_of(tail, k++))
        fill_interval(tail, k, response, first, light.num_beams,
                      table + (size_t)k * (CML_FLAT_TAIL_CELLS + 1) * (size_t)tail->scores);
    scale(tail, table);
    return CML_OK;
}

cml_status cml_tail_create(const struct cml_medium_def *media, int num_layers, int layer, double z,
                           struct cml_flat_tail *tail, struct cml_error *err)
{
    const int layers = num_layers - layer + 1;
    CML_FREED struct cml_medium_def *stack = calloc((size_t)layers + 2, sizeof *stack);
    *tail = (struct cml_flat_tail){.layer = layer, .z = z, .scores = layers};
    tail->index = calloc((size_t)layers + 1, sizeof *tail->index);
    tail->exponent = calloc((size_t)layers, sizeof *tail->exponent);
    cml_status status = stack && tail->index && tail->exponent
                            ? CML_OK
                            : cml_fail_memory(err, layers * (double)sizeof *stack, "layers");
    if (status == CML_OK) {
        stack[0] = media[layer];
        memcpy(stack + 1, media + layer, ((size_t)layers + 1) * sizeof *stack);
        stack[1].d -= z;
        find_intervals(stack + 1, layers + 1, tail);
        status = fill(stack, layers, tail, err);
    }
    if (status != CML_OK) cml_flat_tail_clear(tail);
    return status;
}
