/* Searches the generating vector of kernels/lattice.h and prints it: bench_lattice, seconds.
 * bench_lattice --check prints the criterion for the vector in use.
 * Criterion: the squared error of integrating functions whose mixed first derivatives are square-integrable,
 * the worst of all such functions, averaged over random shifts. With the first n points x_i of a batch it is
 *     e^2 = -1 + 1/n^2 sum_ik prod_d (1 + weight_d B2({x_id - x_kd})),    B2(x) = x^2 - x + 1/6
 * [Sloan, Kuo, Joe: Constructing randomly shifted lattice rules in weighted Sobolev spaces, SIAM J. Numer.
 * Anal. 40 (2002) 1650]. Component by component: for one dimension after the other the odd z below 2^20 is
 * taken, of CANDIDATES drawn at random, with the least product of e^2 over all n searched with: powers of
 * two, which are lattices, so that one sum over the points is enough, and what 1e4 and 1e5 photons give a
 * batch. Additions and multiplications in a fixed order decide. The best candidates lead by 3 % or more of
 * the product, rounding makes less than 1e-9 of it, so the result is the same everywhere.
 * The polar angle of the light comes last, by another criterion: with its z no pair of dimensions may lie
 * badly, whatever power of two the points are. pair_variance() says what is compared.
 * SPDX-License-Identifier: MIT */
#include "lattice.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CANDIDATES = 400, POWER_MIN = 6, POWER_MAX = 16, POWERS = POWER_MAX - POWER_MIN + 1, LANES = 8 };

/* Dimensions from the most important one on, with weights: each interaction counts for less than the one
 * before it. */
static const struct {
    cml_u32 dimension;
    double weight;
} order[CML_LATTICE_DIMENSIONS] = {{0, 1},
                                   {1, 1},
                                   {2, 1},
                                   {3, 0.5},
                                   {4, 0.5},
                                   {5, 0.5},
                                   {6, 0.5},
                                   {8, 0.25},
                                   {9, 0.25},
                                   {10, 0.25},
                                   {CML_LATTICE_SPARE, 0.25},
                                   {11, 0.25},
                                   {12, 0.25},
                                   {13, 0.25}};
enum { POLAR_PLACE = CML_LATTICE_DIMENSIONS - 1, PAIR_POWER_MIN = 4 };

static const int typed[] = {156, 1562, 15625}; /* points that 1e4, 1e5 and 1e6 photons give a batch */
enum { TYPED = sizeof typed / sizeof *typed, SEARCHED = TYPED - 1 }; /* 1e6 takes too long to search with */

/* Differences of points, the product over the dimensions so far at each, and what they count for in e^2: the
 * first is that of a point from itself. */
static struct differences {
    int count;
    cml_u32 *reversed;
    double *product, first_share, share;
} sets[POWERS + SEARCHED];

static cml_u32 reversed(int point)
{
    return cml_lattice_point((cml_u64)point * CML_NUM_BATCHES);
}

/* 1 + weight B2 of a difference of points times z. */
static double factor(cml_u32 difference, double weight)
{
    const double x = difference * 0x1p-32;
    return 1 + weight * (x * (x - 1) + 1.0 / 6);
}

/* ---- the search ---- */

static struct differences new_differences(int count)
{
    struct differences set = {count, malloc((size_t)count * sizeof *set.reversed),
                              malloc((size_t)count * sizeof *set.product), 0, 0};
    if (!set.reversed || !set.product) {
        fputs("bench_lattice: out of memory\n", stderr);
        exit(3);
    }
    for (int i = 0; i < count; i++) set.product[i] = 1;
    return set;
}

/* Of 2^m points: every point of a lattice sees the others where the first one does. */
static struct differences of_lattice(int m)
{
    const int n = 1 << m;
    struct differences set = new_differences(n);
    for (int i = 0; i < n; i++) set.reversed[i] = reversed(i);
    set.first_share = set.share = 1.0 / n;
    return set;
}

/* Of any n points: all pairs. */
static struct differences of_pairs(int n)
{
    struct differences set = new_differences(1 + n * (n - 1) / 2);
    int count = 0;
    set.reversed[count++] = 0;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++) set.reversed[count++] = reversed(i) - reversed(k);
    set.first_share = 1.0 / n;
    set.share = 2.0 / n / n;
    return set;
}

/* Sum of the products but the first with one dimension more, in LANES sums that a compiler may add side by
 * side. */
static double sum_of_products(const struct differences *set, cml_u32 z, double weight)
{
    double sums[LANES] = {0}, sum = 0;
    int i = 1;
    for (; i + LANES <= set->count; i += LANES)
        for (int k = 0; k < LANES; k++)
            sums[k] += set->product[i + k] * factor(set->reversed[i + k] * z, weight);
    for (; i < set->count; i++) sum += set->product[i] * factor(set->reversed[i] * z, weight);
    for (int k = 0; k < LANES; k++) sum += sums[k];
    return sum;
}

/* Product of e^2 over the sets, with z as one dimension more. */
static double criterion(cml_u32 z, double weight)
{
    double product = 1;
    for (int i = 0; i < POWERS + SEARCHED; i++) {
        const struct differences *set = &sets[i];
        const double same = set->product[0] * factor(0, weight);
        product *= set->first_share * same + set->share * sum_of_products(set, z, weight) - 1;
    }
    return product;
}

static void keep(cml_u32 z, double weight)
{
    for (int i = 0; i < POWERS + SEARCHED; i++)
        for (int k = 0; k < sets[i].count; k++) sets[i].product[k] *= factor(sets[i].reversed[k] * z, weight);
}

/* Variance of a mean over 2^m points of a lattice, over that of random points, averaged over shifts: of a
 * function of two coordinates that is the product of two Bernoulli polynomials B2, with these generators. */
static double pair_variance(int m, cml_u32 z1, cml_u32 z2)
{
    const double same = factor(0, 1) - 1;
    double sum = 0;
    for (int i = 0; i < 1 << m; i++)
        sum += (factor(reversed(i) * z1, 1) - 1) * (factor(reversed(i) * z2, 1) - 1);
    return sum / same / same;
}

/* Sum of the squares of pair_variance of `z` with all other dimensions in use, times their weights, over all
 * powers: squares, because one bad pair is worse than several fair ones. */
static double pairs_of_polar(cml_u32 z)
{
    double sum = 0;
    for (int m = PAIR_POWER_MIN; m <= POWER_MAX; m++)
        for (unsigned place = 0; place < POLAR_PLACE; place++) {
            if (order[place].dimension == CML_LATTICE_SPARE) continue;
            const double variance = pair_variance(m, z, cml_lattice_generator(order[place].dimension)),
                         counted = order[place].weight * variance;
            sum += counted * counted;
        }
    return sum;
}

static double value_of(unsigned place, cml_u32 z)
{
    return place == POLAR_PLACE ? pairs_of_polar(z) : criterion(z, order[place].weight);
}

static cml_u32 best_candidate(unsigned place)
{
    const struct cml_stream stream = {.key = {20261122}};
    double least = INFINITY;
    cml_u32 best = 1;
    for (cml_u32 c = 0; place > 0 && c < CANDIDATES; c++) {
        const cml_u32 z = cml_draw(stream, place, CML_PURPOSE_LAUNCH, c).w[0] >> 12 | 1u;
        const double value = value_of(place, z);
        if (value < least) least = value, best = z;
    }
    return best;
}

/* Returns whether what is found is the vector in use. */
static int search(void)
{
    int same = 1;
    for (int m = POWER_MIN; m <= POWER_MAX; m++) sets[m - POWER_MIN] = of_lattice(m);
    for (int i = 0; i < SEARCHED; i++) sets[POWERS + i] = of_pairs(typed[i]);
    for (unsigned place = 0; place < CML_LATTICE_DIMENSIONS; place++) {
        const cml_u32 dimension = order[place].dimension, z = best_candidate(place);
        same &= z == cml_lattice_generator(dimension);
        keep(z, order[place].weight);
        printf("dimension %2u: z = %7u\n", dimension, z);
        fflush(stdout);
    }
    puts(same ? "the vector of kernels/lattice.h" : "not the vector of kernels/lattice.h");
    for (int i = 0; i < POWERS + SEARCHED; i++) free(sets[i].reversed), free(sets[i].product);
    return same;
}

/* ---- the vector in use ---- */

static double product_in_use(cml_u32 difference)
{
    double product = 1;
    for (unsigned place = 0; place < CML_LATTICE_DIMENSIONS; place++) {
        if (order[place].dimension == CML_LATTICE_SPARE) continue;
        product *= factor(difference * cml_lattice_generator(order[place].dimension), order[place].weight);
    }
    return product;
}

static double lattice_error(int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += product_in_use(reversed(i));
    return sqrt(sum / n - 1);
}

static double pairs_error(int n)
{
    double sum = n * product_in_use(0) / 2;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++) sum += product_in_use(reversed(i) - reversed(k));
    return sqrt(2 * sum / n / n - 1);
}

/* Root of the mean e^2 of n random points. */
static double random_error(int n)
{
    return sqrt((product_in_use(0) - 1) / n);
}

static void print_error(int n, double error)
{
    printf("%8d %11.4g %11.4g %8.1f\n", n, error, random_error(n), random_error(n) / error);
    fflush(stdout);
}

static void check(void)
{
    puts("  points           e      random    ratio");
    for (int m = POWER_MIN; m <= POWER_MAX; m++) print_error(1 << m, lattice_error(1 << m));
    for (int i = 0; i < TYPED; i++) print_error(typed[i], pairs_error(typed[i]));
}

int main(int argc, char **argv)
{
    if (argc == 1) return search() ? 0 : 1;
    if (argc == 2 && !strcmp(argv[1], "--check")) {
        check();
        return 0;
    }
    fputs("usage: bench_lattice [--check]\n", stderr);
    return 2;
}
