/* Tests of the cosines that kernels/optics.h draws from tables of phase functions, in single precision.
 * They are compared with the densities of samples/manual/input/phase-functions.md, which are written out
 * here and integrated by Simpson's rule. SPDX-License-Identifier: MIT */
#include "engine/world.h"
#include "lib/case_files.h"
#include "lib/dice.h"
#include "lib/require.h"
#include "input/mci.h"
#include "optics.h"

#include <math.h>
#include <stdlib.h>

static long draws = 10000000 / SANITIZED_STEP; /* number of draws; argument 1 of the program */

/* Densities of the phase functions over the cosine c = 1 - x. */
static double hg(double g, double x)
{
    return (1 - g * g) / 2 / pow((1 - g) * (1 - g) + 2 * g * x, 1.5);
}

static double two(const double *n, double x)
{
    return n[2] * hg(n[0], x) + (1 - n[2]) * hg(n[1], x);
}

static double modified(const double *n, double x)
{
    return n[1] * hg(n[0], x) + (1 - n[1]) * 1.5 * (1 - x) * (1 - x);
}

static double reynolds_mccormick(const double *n, double x)
{
    const double g = n[0], a = n[1], base = (1 - g) * (1 - g) + 2 * g * x;
    if (g == 0) return 0.5;
    if (a == 0) return g / log((1 + g) / (1 - g)) / base;
    return 2 * a * g * pow(1 - g * g, 2 * a) / (pow(1 + g, 2 * a) - pow(1 - g, 2 * a)) / pow(base, a + 1);
}

static double rayleigh(const double *n, double x)
{
    (void)n;
    return 0.375 * (1 + (1 - x) * (1 - x));
}

/* Rows of a tabulated phase function, linear in the cosine between rows, on any scale. */
#define ROWS 9
static const double rows[ROWS][2] = {{0, 0},  {1, 900}, {3, 250},   {20, 20}, {60, 0},
                                     {90, 0}, {91, 8},  {170, 0.3}, {180, 2}};

static double deflection(double degrees)
{
    return 2 * pow(sin(degrees * (acos(-1.0) / 360)), 2);
}

static double table(const double *n, double x)
{
    int i = 0;
    (void)n;
    while (i < ROWS - 2 && deflection(rows[i + 1][0]) < x) i++;
    const double a = deflection(rows[i][0]), b = deflection(rows[i + 1][0]);
    return rows[i][1] + (rows[i + 1][1] - rows[i][1]) * (x - a) / (b - a);
}

static const struct law {
    const char *line;
    double (*density)(const double *n, double x);
    double number[3];
} laws[] = {{"hg2 0.9 0.9 0.3", two, {0.9, 0.9, 0.3}},
            {"hg2 0.95 -0.4 0.9", two, {0.95, -0.4, 0.9}},
            {"hg2 -0.99 0.99 0.7", two, {-0.99, 0.99, 0.7}},
            {"mhg 0.9 0.8", modified, {0.9, 0.8}},
            {"mhg -0.7 0.9", modified, {-0.7, 0.9}},
            {"gk 0.9 0.5", reynolds_mccormick, {0.9, 0.5}},
            {"gk 0.8 0", reynolds_mccormick, {0.8, 0}},
            {"gk 0.95 -0.3", reynolds_mccormick, {0.95, -0.3}},
            {"gk -0.6 2", reynolds_mccormick, {-0.6, 2}},
            {"gk 0 1", reynolds_mccormick, {0, 1}},
            {"rayleigh", rayleigh, {0}},
            {"table \"p.txt\"", table, {0}}};
enum { LAWS = sizeof laws / sizeof *laws, MOMENTS = 8, STEPS = 100000 };

/* A phase function on a fine grid of angles, from the forward direction on: the share below each angle,
 * and its Legendre moments. */
struct integral {
    double below[STEPS + 1]; /* share of light below each angle of even index */
    double all;              /* integral of the density before it is normalised */
    double moment[MOMENTS + 1];
};

/* Adds weight P_l(c) to sum[l] for each l. Adds weight P_l(c)^2 to squares[l], unless squares is NULL. */
static void add_legendre(double c, double weight, double *sum, double *squares)
{
    double before = 1, p = c;
    for (int l = 1; l <= MOMENTS; l++) {
        const double share = 1.0 / (l + 1), next = (2 - share) * c * p - (1 - share) * before;
        sum[l] += weight * p;
        if (squares) squares[l] += p * p;
        before = p;
        p = next;
    }
}

/* Returns angle i of the grid and its slope. Angles crowd near both ends: t = pi (s - sin(2 pi s) / (2
 * pi)). */
static double angle_at(int i, double *slope)
{
    const double pi = acos(-1.0), s = (double)i / STEPS;
    *slope = pi * (1 - cos(2 * pi * s));
    return pi * (s - sin(2 * pi * s) / (2 * pi));
}

/* 1 - c at each angle of the grid, filled by setup. */
static double deflection_at[STEPS + 1];

static void fill_deflections(void)
{
    double slope;
    for (int i = 0; i <= STEPS; i++) deflection_at[i] = 2 * pow(sin(angle_at(i, &slope) / 2), 2);
}

static double integrand(const struct law *law, int i)
{
    double slope;
    const double t = angle_at(i, &slope);
    return law->density(law->number, 2 * pow(sin(t / 2), 2)) * sin(t) * slope / STEPS;
}

static void integrate(const struct law *law, struct integral *to)
{
    memset(to, 0, sizeof *to);
    for (int i = 0; i < STEPS; i += 2) {
        const double part[3] = {integrand(law, i) / 3, integrand(law, i + 1) * 4 / 3,
                                integrand(law, i + 2) / 3};
        to->below[i + 2] = to->below[i] + part[0] + part[1] + part[2];
        for (int k = 0; k < 3; k++) add_legendre(1 - deflection_at[i + k], part[k], to->moment, NULL);
    }
    const double all = to->all = to->below[STEPS];
    for (int i = 0; i <= STEPS; i += 2) to->below[i] /= all;
    for (int l = 1; l <= MOMENTS; l++) to->moment[l] /= all;
}

/* One scene of one layer per phase function, and the world of each scene, shared by all tests. */
static struct {
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct cml_owned_world world;
    struct integral integral[LAWS];
} all;

static void open_all(void **state)
{
    struct cml_error err;
    char path[256], text[4096], numbers[512] = "# angle p\n\n";
    const struct cml_engine_options options = {.seed = 1, .threads = 1, .roulette = {0.01, 0.03}};
    const struct cml_surface_options surface = {.force = CML_SURFACE_AUTO,
                                                .tessellation = {.tolerance = 1e-3}};
    int n = snprintf(text, sizeof text, "1.0\n1\nx A\n1\n1 1\n1 1 1\n%d\n1\n", LAWS);
    for (int i = 0; i < LAWS; i++) {
        integrate(&laws[i], &all.integral[i]);
        n += snprintf(text + n, sizeof text - (size_t)n, "1.4 1 10 %.6f 1\nphase %s\n",
                      all.integral[i].moment[1], laws[i].line);
    }
    snprintf(text + n, sizeof text - (size_t)n, "1\n");
    n = (int)strlen(numbers);
    for (int i = 0; i < ROWS; i++)
        n += snprintf(numbers + n, sizeof numbers - (size_t)n, "%g %g # row\n", rows[i][0], rows[i][1]);
    case_write(state, "p.txt", numbers);
    case_write(state, "x.mci", text);
    case_path(state, "x.mci", path);
    require_ok(cml_mci_read(path, NULL, &all.list, &err), &err);
    require_ok(cml_surfaces_create(all.list.scenes, &surface, &all.surfaces, &err), &err);
    require_ok(cml_owned_world_create(all.list.scenes, &all.surfaces, &options, &all.world, &err), &err);
    assert_true(all.world.world.only_tables);
    case_remove(state, "x.mci");
    case_remove(state, "p.txt");
}

static int setup(void **state)
{
    if (case_setup(state)) return -1;
    fill_deflections();
    open_all(state);
    return 0;
}

static int teardown(void **state)
{
    cml_owned_world_free(&all.world);
    cml_surfaces_free(&all.surfaces);
    cml_scene_list_clear(&all.list);
    return case_teardown(state);
}

/* Returns 1 - c of the cosine that a random word draws; 1 + c if the phase function is mirrored. */
static double drawn(const struct cml_world *world, real g, uint32_t word)
{
    const struct cml_phase_cell cell =
        cml_phase_cell_at(world->phase_cells, cml_phase_cell_number(g, word), word);
    const real value = cml_phase_one_minus(cell, word);
    assert_true(value >= 0 && value <= 2);
    return (double)value;
}

/* Returns the share of light deflected by less than x, interpolated linearly between places of the grid. */
static double share_below(const struct integral *integral, double x)
{
    int low = 0, high = STEPS;
    while (high - low > 2) {
        const int middle = (low + high) / 4 * 2;
        if (deflection_at[middle] < x)
            low = middle;
        else
            high = middle;
    }
    const double a = deflection_at[low], b = deflection_at[high];
    return integral->below[low] + (integral->below[high] - integral->below[low]) * (x - a) / (b - a);
}

/* The drawn distribution keeps its stated bound, 2^-18. Two roundings of 1 - c and the error of the grid
 * are allowed on top. */
static void the_distribution_is_met_to_two_to_the_minus_18(void **state)
{
    (void)state;
    const double bound = ldexp(1, -18);
    for (int i = 0; i < LAWS; i++) {
        const real g = all.world.media[i + 1].g;
        double worst = 0;
        assert_true(g < 0 ? all.integral[i].moment[1] < 0 : all.integral[i].moment[1] > -1e-9);
        for (uint32_t k = 0; k < 1u << 20; k++) {
            const double share = (k + 0.5) / (1u << 20);
            const uint32_t word = ((k << 12) + (1u << 11)) ^ 0x7fffffffu;
            const double x = drawn(&all.world.world, g, word);
            const double below =
                g < 0 ? 1 - share_below(&all.integral[i], 2 - x) : share_below(&all.integral[i], x);
            const double density = laws[i].density(laws[i].number, g < 0 ? 2 - x : x) / all.integral[i].all;
            worst = fmax(worst, fabs(below - share) - 2.4e-7 * x * density);
        }
        if (worst > 1.02 * bound) fail_msg("%s: off by %g, more than %g", laws[i].line, worst, bound);
    }
}

/* The first eight Legendre moments of randomly drawn cosines agree with the density: |z| < 4.5 for all 96
 * moments. */
static void legendre_moments_are_those_of_the_density(void **state)
{
    struct dice dice = dice_new(61);
    (void)state;
    for (int i = 0; i < LAWS; i++) {
        const struct cml_vec z = {0, 0, 1};
        double sum[MOMENTS + 1] = {0}, squares[MOMENTS + 1] = {0};
        for (long k = 0; k < draws; k++) {
            const uint32_t word = dice_word(&dice);
            const struct cml_vec u = cml_scatter_in(all.world.world.phase_cells, z, all.world.media[i + 1].g,
                                                    word, word * 2654435761u);
            add_legendre((double)u.z, 1, sum, squares);
        }
        for (int l = 1; l <= MOMENTS; l++) {
            const double mean = sum[l] / (double)draws, expected = all.integral[i].moment[l];
            const double error = sqrt((squares[l] / (double)draws - mean * mean) / (double)draws);
            if (fabs(mean - expected) > 4.5 * error)
                fail_msg("%s: moment %d is %.8f, not %.8f (z = %.2f)", laws[i].line, l, mean, expected,
                         (mean - expected) / error);
        }
    }
}

/* Parameters that reduce a phase function to Henyey and Greenstein's draw the same cosine as that function
 * for every random word. */
static void equal_functions_give_equal_cosines(void **state)
{
    struct dice dice = dice_new(62);
    (void)state;
    const struct cml_vec z = {0, 0, 1};
    double differs = 0;
    for (int k = 0; k < 100000; k++) {
        const uint32_t word = dice_word(&dice);
        const struct cml_vec law = cml_scatter(z, (real)0.9, word, 1),
                             by_table = cml_scatter_in(all.world.world.phase_cells, z, all.world.media[1].g,
                                                       word, 1);
        differs += fabs((double)law.z - (double)by_table.z) / 100000;
    }
    assert_near("mean difference of the cosines", differs, 0, 1e-5);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_distribution_is_met_to_two_to_the_minus_18),
        cmocka_unit_test(legendre_moments_are_those_of_the_density),
        cmocka_unit_test(equal_functions_give_equal_cosines),
    };
    if (argc > 1) draws = atol(argv[1]);
    return cmocka_run_group_tests_name("phase_table", tests, setup, teardown);
}
