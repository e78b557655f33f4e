/* Tests of totals by adding-doubling against other programs' adding-doubling (tests/reference), closed
 * forms and theorems, never against this program. SPDX-License-Identifier: MIT */
#include "exact/exact.h"
#include "exact/phase_moments.h"

#include "lib/dice.h"
#include "lib/require.h"
#include "lib/sanitized.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>

enum { MOST_LAYERS = 8 };

static const double pi = 3.14159265358979323846;

/* A stack of layers between two outer media. */
struct stack {
    int layers;
    struct cml_medium_def media[MOST_LAYERS + 2];
};

static struct stack stack_of(double above, double below)
{
    struct stack stack = {.layers = 0};
    stack.media[0].n = above;
    stack.media[1].n = below;
    return stack;
}

static void add(struct stack *stack, double n, double mua, double mus, double g, double d)
{
    stack->media[stack->layers + 2] = stack->media[stack->layers + 1];
    stack->media[++stack->layers] = (struct cml_medium_def){.n = n, .mua = mua, .mus = mus, .g = g, .d = d};
}

static struct stack slab(double n, double mua, double mus, double g, double d)
{
    struct stack stack = stack_of(1, 1);
    add(&stack, n, mua, mus, g, d);
    return stack;
}

/* Solves a stack; the caller clears the totals. With sanitizers no error below 1e-5 is asked for, to save
 * time. */
static struct cml_exact solve(const struct stack *stack, bool diffuse, double angle, double tolerance)
{
    struct cml_exact_ray beam = {cos(angle), 1};
    const struct cml_exact_light light = {.diffuse = diffuse, .num_beams = !diffuse, .beam = &beam};
    const struct cml_exact_options options = {.tolerance = SANITIZED ? fmax(tolerance, 1e-5) : tolerance,
                                              .most_work = 1e11};
    struct cml_exact exact;
    struct cml_error err;
    require_ok(cml_exact_solve(stack->media, stack->layers, &light, &options, &exact, &err), &err);
    assert_true(exact.converged);
    return exact;
}

/* Checks that reflected light (with specular light) and transmitted light agree within stated error +
 * margin. */
static void expect(const char *what, const struct stack *stack, bool diffuse, double angle, double reflected,
                   double transmitted, double margin)
{
    struct cml_exact exact = solve(stack, diffuse, angle, 1e-7);
    const double *value = exact.value, *error = exact.error;
    assert_near(what, value[CML_EXACT_RSP] + value[CML_EXACT_RD], reflected, error[CML_EXACT_RD] + margin);
    assert_near(what, value[CML_EXACT_TT], transmitted, error[CML_EXACT_TT] + margin);
    assert_near(what, value[CML_EXACT_A], 1 - reflected - transmitted, error[CML_EXACT_A] + 2 * margin);
    cml_exact_clear(&exact);
}

/* Parses one row of layers.csv, "n/mua/mus/g/d|...". */
static struct stack parse_layers(const char *text)
{
    struct stack stack = stack_of(1, 1);
    double q[5];
    while (sscanf(text, "%lf/%lf/%lf/%lf/%lf", q, q + 1, q + 2, q + 3, q + 4) == 5) {
        add(&stack, q[0], q[1], q[2], q[3], q[4]);
        text = strpbrk(text, "|,");
        if (!text || *text++ == ',') break;
    }
    return stack;
}

static FILE *open_reference(const char *name)
{
    FILE *file = fopen(name, "r");
    if (!file) fail_msg("%s is not there", name);
    return file;
}

/* The tables have seven digits and claim 1e-7 for stacks. The stated error must cover the rest. */
static void slabs_agree_with_other_adding_doubling(void **state)
{
    (void)state;
    char line[512];
    int rows = 0;
    FILE *file = open_reference("reference/slabs.csv");
    while (fgets(line, sizeof line, file)) {
        double n, outside, mua, mus, g, d, R, T;
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &n, &outside, &mua, &mus, &g, &d, &R, &T) != 8)
            continue;
        if (rows++ % cases_step()) continue;
        struct stack stack = stack_of(outside, outside);
        add(&stack, n, mua, mus, g, d);
        struct cml_exact exact = solve(&stack, false, 0, 1e-6);
        assert_near(line, exact.value[CML_EXACT_RSP] + exact.value[CML_EXACT_RD], R,
                    exact.error[CML_EXACT_RD] + 6e-8);
        assert_near(line, exact.value[CML_EXACT_TT], T, exact.error[CML_EXACT_TT] + 6e-8);
        cml_exact_clear(&exact);
    }
    fclose(file);
    assert_int_equal(rows, 228);
}

static void stacks_agree_with_other_adding_doubling(void **state)
{
    (void)state;
    char line[512];
    int rows = 0;
    FILE *file = open_reference("reference/layers.csv");
    while (fgets(line, sizeof line, file)) {
        const char *layers = strchr(line, ',');
        const char *totals = layers ? strchr(layers + 1, ',') : NULL;
        double R, T;
        if (line[0] == '#' || !totals || sscanf(totals, ",%lf,%lf", &R, &T) != 2) continue;
        if (rows++ % SANITIZED_STEP) continue;
        const struct stack stack = parse_layers(layers + 1);
        expect(line, &stack, false, 0, R, T, 1.5e-7);
    }
    fclose(file);
    assert_int_equal(rows, 6);
}

/* Returns Fresnel's reflectance from angles; a is the angle in the medium of index n1. */
static double reflectance(double n1, double n2, double a)
{
    const double sine = n1 / n2 * sin(a), b = asin(fmin(sine, 1));
    if (sine >= 1) return 1;
    if (a == 0) return pow((n1 - n2) / (n1 + n2), 2);
    return (pow(sin(a - b) / sin(a + b), 2) + pow(tan(a - b) / tan(a + b), 2)) / 2;
}

/* Sums all internal reflections of a plate without scattering in air: reflectance R, transmittance T. */
static void plate(double n, double mua, double d, double angle, double *R, double *T)
{
    const double r = reflectance(1, n, angle), t = exp(-mua * d / sqrt(1 - pow(sin(angle) / n, 2)));
    *R = r + (1 - r) * (1 - r) * r * t * t / (1 - r * r * t * t);
    *T = (1 - r) * (1 - r) * t / (1 - r * r * t * t);
}

static void plates_obey_fresnel_and_beer(void **state)
{
    (void)state;
    const double angles[] = {0, 0.1, 0.9827937232473290, 1.5, 1.5707};
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 3; k++) {
            double R, T;
            const struct stack stack = slab(1.5, k, 0, 0, 0.3);
            plate(1.5, k, 0.3, angles[i], &R, &T);
            expect("plate", &stack, false, angles[i], R, T, 1e-13);
        }
}

/* Diffuse light on a plate without scattering, by Simpson's rule over the angle. */
static void plates_in_diffuse_light(void **state)
{
    (void)state;
    enum { STEPS = 20000 };
    for (int k = 0; k < 3; k++) {
        double sum_R = 0, sum_T = 0;
        for (int i = 0; i < STEPS; i++) {
            const double a = pi / 2 * i / STEPS, weight = i % 2 == 0 ? 2 : 4;
            double R, T;
            plate(1.5, k, 0.3, a, &R, &T);
            sum_R += weight * R * sin(2 * a);
            sum_T += weight * T * sin(2 * a);
        }
        const struct stack stack = slab(1.5, k, 0, 0, 0.3);
        const double step = pi / 2 / STEPS / 3;
        expect("diffuse", &stack, true, 0, sum_R * step, sum_T * step, 1e-10);
    }
}

/* Specular light is one reflection; on a glass plate at normal incidence it is both (rule P1). */
static void specular_light_is_split_as_by_the_program(void **state)
{
    (void)state;
    struct stack stack = stack_of(1, 1.2);
    add(&stack, 1.5, 0, 0, 0, 0.1);
    add(&stack, 1.4, 1, 10, 0.5, 0.1);
    struct cml_exact normal = solve(&stack, false, 0, 1e-6), oblique = solve(&stack, false, 0.5, 1e-6);
    const double r1 = reflectance(1, 1.5, 0), r2 = reflectance(1.5, 1.4, 0);
    assert_near("glass", normal.value[CML_EXACT_RSP], r1 + (1 - r1) * (1 - r1) * r2 / (1 - r1 * r2), 1e-15);
    assert_near("oblique", oblique.value[CML_EXACT_RSP], reflectance(1, 1.5, 0.5), 1e-15);
    cml_exact_clear(&normal);
    cml_exact_clear(&oblique);
}

/* Returns Chandrasekhar's H function for isotropic scattering of albedo w, in the closed form of Stibbs
 * and Weir (1959), by Simpson's rule. */
static double chandrasekhar(double w, double mu)
{
    enum { STEPS = 4000 };
    double sum = 0;
    for (int i = 1; i <= STEPS; i++) {
        const double a = pi / 2 * i / STEPS, c = cos(a), s = sin(a);
        const double f = log(1 - w * (i < STEPS ? a * c / s : 0)) / (c * c + mu * mu * s * s);
        sum += (i == STEPS ? 1 : i % 2 == 0 ? 2 : 4) * f;
    }
    sum += log(1 - w);
    return exp(-mu / pi * sum * pi / 2 / STEPS / 3);
}

/* A half space absorbs the share H(mu) sqrt(1 - w) of light that strikes it at the cosine mu. */
static void a_half_space_follows_chandrasekhar(void **state)
{
    (void)state;
    const double albedos[] = {0.1, 0.5, 0.9}, cosines[] = {1, 0.7, 0.3};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            const double w = albedos[i], absorbed = chandrasekhar(w, cosines[k]) * sqrt(1 - w);
            const struct stack stack = slab(1, 1 - w, w, 0, 1e9);
            expect("half space", &stack, false, acos(cosines[k]), 1 - absorbed, 0, 1e-9);
        }
}

/* Backward scattering alone has two streams (Kubelka and Munk). Forward scattering alone only absorbs. */
static void extreme_anisotropy_has_closed_forms(void **state)
{
    (void)state;
    const double c = cos(0.8), K = 0.7 / c, S = 3 / c, d = 0.4, b = sqrt(K * (K + 2 * S));
    const double D = (K + S) * sinh(b * d) + b * cosh(b * d);
    const struct stack back = slab(1, 0.7, 3, -1, d), on = slab(1, 0.7, 3, 1, d);
    expect("g = -1", &back, false, 0.8, S * sinh(b * d) / D, b / D, 1e-13);
    expect("g = 1", &on, false, 0.8, 0, exp(-K * d), 1e-13);
}

static struct stack mixed_stack(void)
{
    struct stack stack = stack_of(1.2, 1.45);
    add(&stack, 1.5, 0.1, 3, 0.8, 0.2);
    add(&stack, 1.33, 0.5, 1, -0.4, 0.3);
    add(&stack, 1.4, 0, 20, 0.9, 0.05);
    return stack;
}

static struct stack upside_down(const struct stack *stack)
{
    struct stack turned = *stack;
    for (int m = 0; m <= stack->layers + 1; m++) turned.media[m] = stack->media[stack->layers + 1 - m];
    return turned;
}

/* Helmholtz reciprocity: the etendue transmitted between the outer media is the same in both directions. */
static void transmission_is_reciprocal(void **state)
{
    (void)state;
    if (SANITIZED) skip(); /* the test needs a small error */
    const struct stack stack = mixed_stack(), turned = upside_down(&stack);
    struct cml_exact down = solve(&stack, true, 0, 1e-9), up = solve(&turned, true, 0, 1e-9);
    assert_near("reciprocity", 1.2 * 1.2 * down.value[CML_EXACT_TT], 1.45 * 1.45 * up.value[CML_EXACT_TT],
                3e-9);
    assert_true(fabs(down.value[CML_EXACT_TT] - up.value[CML_EXACT_TT]) > 0.05);
    cml_exact_clear(&down);
    cml_exact_clear(&up);
}

/* The first layer is cut in two: nothing else changes, and both parts absorb as much as the layer did. */
static void a_layer_in_two_parts_is_the_same(void **state)
{
    (void)state;
    const struct stack whole = mixed_stack();
    struct stack parts = stack_of(1.2, 1.45);
    add(&parts, 1.5, 0.1, 3, 0.8, 0.15);
    add(&parts, 1.5, 0.1, 3, 0.8, 0.05);
    for (int m = 2; m <= 3; m++)
        add(&parts, whole.media[m].n, whole.media[m].mua, whole.media[m].mus, whole.media[m].g,
            whole.media[m].d);
    struct cml_exact a = solve(&whole, false, 0.6, 1e-6), b = solve(&parts, false, 0.6, 1e-6);
    assert_int_equal(a.order, b.order);
    for (int i = 0; i < CML_EXACT_LAYERS; i++) assert_near("total", b.value[i], a.value[i], 1e-13);
    assert_near("parts", b.value[CML_EXACT_LAYERS] + b.value[CML_EXACT_LAYERS + 1], a.value[CML_EXACT_LAYERS],
                1e-13);
    for (int l = 1; l <= 2; l++)
        assert_near("layer", b.value[CML_EXACT_LAYERS + l + 1], a.value[CML_EXACT_LAYERS + l], 1e-13);
    cml_exact_clear(&a);
    cml_exact_clear(&b);
}

/* Light that can never occur must not make a matrix singular: glass in which light would be trapped,
 * layers without thickness, a totally reflected beam, indices that differ by rounding, a half space that
 * absorbs nothing. */
/* More layers than one block holds, in slanted light that is refracted between blocks, absorb the same. */
static void layers_in_many_parts_absorb_the_same(void **state)
{
    (void)state;
    enum { PARTS = SANITIZED ? 50 : 150 };
    static const struct cml_medium_def layer[2] = {{.n = 1.5, .mua = 2, .mus = 3, .g = 0.5, .d = 0.3},
                                                   {.n = 1.3, .mua = 1, .mus = 9, .g = 0.8, .d = 0.6}};
    struct stack whole = stack_of(1, 1.2);
    struct cml_medium_def media[2 * PARTS + 2] = {{.n = 1}};
    struct cml_exact_ray beam = {cos(0.7), 1};
    const struct cml_exact_light light = {.num_beams = 1, .beam = &beam};
    const struct cml_exact_options options = {.tolerance = 1e-4, .most_work = 1e11};
    for (int i = 0; i < 2 * PARTS; i++) {
        media[i + 1] = layer[i / PARTS];
        media[i + 1].d /= PARTS;
    }
    media[2 * PARTS + 1].n = 1.2;
    for (int i = 0; i < 2; i++) add(&whole, layer[i].n, layer[i].mua, layer[i].mus, layer[i].g, layer[i].d);
    struct cml_exact expected = solve(&whole, false, 0.7, 1e-6), parts;
    struct cml_error err;
    require_ok(cml_exact_solve(media, 2 * PARTS, &light, &options, &parts, &err), &err);
    for (int i = 0; i < CML_EXACT_LAYERS; i++) assert_near("share", parts.value[i], expected.value[i], 1e-4);
    for (int k = 0; k < 2; k++) {
        double sum = 0;
        for (int i = 0; i < PARTS; i++) sum += parts.value[CML_EXACT_LAYERS + k * PARTS + i];
        assert_near("absorbed", sum, expected.value[CML_EXACT_LAYERS + k], 1e-4);
    }
    cml_exact_clear(&expected);
    cml_exact_clear(&parts);
}

static void limits_are_finite_and_keep_all_light(void **state)
{
    (void)state;
    struct stack stacks[6] = {stack_of(1, 1), slab(1.5, 0, 10, 0.5, 0),    stack_of(1.5, 1.5),
                              stack_of(1, 1), slab(1.4, 0, 100, 0.9, 1e4), slab(1.5, 0, 10, -1, 1)};
    add(&stacks[0], 1.5, 0, 0, 0, 0.1);
    add(&stacks[0], 1.5000001, 0, 0, 0, 0.1);
    add(&stacks[0], 1.5, 0, 1e-12, 0, 0.1);
    add(&stacks[2], 1.2, 0, 0, 0, 0.1);
    add(&stacks[2], 1.6, 0, 5, 0.5, 0.1);
    add(&stacks[3], 1.4, 0, 5, 0.5, 0.1);
    add(&stacks[3], nextafter(1.4, 2), 0, 5, 0.5, 0.1);
    for (int i = 0; i < 6; i++) {
        struct cml_exact exact = solve(&stacks[i], false, 1.2, 1e-6);
        double sum = -exact.value[CML_EXACT_A];
        for (int k = 0; k < exact.count; k++) {
            assert_true(isfinite(exact.value[k]));
            sum += exact.value[k];
        }
        assert_near("all light", sum, 1, exact.error[CML_EXACT_TT] + 1e-15);
        assert_near("absorbed", exact.value[CML_EXACT_A], 0, 1e-15);
        if (i == 2) assert_near("total reflection", exact.value[CML_EXACT_RSP], 1, 1e-15);
        cml_exact_clear(&exact);
    }
}

/* Returns k, the inverse diffusion length of light deep in a medium, in mean free paths. exp(-k tau)
 * solves the equation of transfer if the moments psi_l of its radiance obey a_l psi_l = k ((l + 1)
 * psi_{l+1} + l psi_{l-1}), a_l = (2 l + 1) (1 - w g^l). Hence a_0 = k^2 / (a_1 - 4 k^2 / (a_2 - 9 k^2 /
 * ...)), solved by bisection. */
static long double diffusion_exponent(long double w, long double g)
{
    long double low = 0, high = 1;
    for (int step = 0; step < 200; step++) {
        const long double k = (low + high) / 2;
        long double rest = 0;
        for (int l = 400; l > 0; l--) {
            const long double next = rest != 0 ? (l + 1) * (l + 1) * k * k / rest : 0;
            rest = (2 * l + 1) * (1 - w * powl(g, l)) - next;
        }
        if (k * k < (1 - w) * rest)
            low = k;
        else
            high = k;
    }
    return low;
}

/* Transmission of a thick slab falls by exp(-k) per mean free path, within the stated relative error. */
static void thick_slabs_lose_light_as_in_the_milne_problem(void **state)
{
    (void)state;
    if (SANITIZED) skip(); /* the test needs a small error */
    const double g[] = {0, 0.9, -0.5}, lengths[] = {14, 20, 40, 300};
    for (int i = 0; i < 3; i++) {
        const double exponent = (double)diffusion_exponent(100 / 100.5L, g[i]) * 100.5;
        struct cml_exact exact[4];
        for (int k = 0; k < 4; k++) {
            const struct stack stack = slab(1.4, 0.5, 100, g[i], lengths[k] / exponent);
            exact[k] = solve(&stack, false, 0, 1e-7);
            assert_true(exact[k].value[CML_EXACT_TT] > 0);
            assert_true(exact[k].error[CML_EXACT_TT] < 1e-5 * exact[k].value[CML_EXACT_TT]);
        }
        for (int k = 1; k < 4; k++) {
            const double *thin = exact[k - 1].value, *thick = exact[k].value;
            const double error = exact[k - 1].error[CML_EXACT_TT] / thin[CML_EXACT_TT] +
                                 exact[k].error[CML_EXACT_TT] / thick[CML_EXACT_TT];
            assert_near("exponent", log(thin[CML_EXACT_TT] / thick[CML_EXACT_TT]),
                        lengths[k] - lengths[k - 1], error);
        }
        for (int k = 0; k < 4; k++) cml_exact_clear(&exact[k]);
    }
}

/* A slab doubled by the layer's own doubling equals two added halves, but for rounding. */
static void thick_slabs_are_two_halves(void **state)
{
    (void)state;
    const double depth[] = {0.01, 4.95, 9.9, 40};
    for (int i = 0; i < 4; i += SANITIZED ? 3 : 1) {
        const struct stack whole = slab(1.4, 0.5, 100, 0.9, depth[i]);
        struct stack halves = slab(1.4, 0.5, 100, 0.9, depth[i] * 3 / 8);
        add(&halves, 1.4, 0.5, 100, 0.9, depth[i] * 5 / 8);
        struct cml_exact a = solve(&whole, false, 0, 1e-6), b = solve(&halves, false, 0, 1e-6);
        assert_near("halves", b.value[CML_EXACT_TT] / a.value[CML_EXACT_TT], 1, 1e-11);
        cml_exact_clear(&a);
        cml_exact_clear(&b);
    }
}

/* Returns a random stack of one to three layers, up to some 30 mean free paths thick. */
static struct stack random_stack(struct dice *dice)
{
    static const double indices[] = {1, 1.33, 1.4, 1.5};
    struct stack stack = stack_of(indices[dice_below(dice, 4)], indices[dice_below(dice, 4)]);
    const int layers = 1 + dice_below(dice, 3);
    for (int l = 0; l < layers; l++) {
        const double n = dice_below(dice, 2) ? indices[dice_below(dice, 4)] : 1 + 0.5 * dice_uniform(dice);
        const double mut = pow(10, -1 + 2.5 * dice_uniform(dice)), share = pow(10, -3 * dice_uniform(dice));
        const double g = dice_below(dice, 4) == 0 ? 0 : -0.5 + 1.45 * dice_uniform(dice);
        add(&stack, n, mut * share, mut * (1 - share), g, pow(10, -2 + 1.5 * dice_uniform(dice)));
    }
    return stack;
}

/* Errors stated at low orders cover the difference from results at high orders. */
static void stated_errors_are_no_smaller_than_true_ones(void **state)
{
    (void)state;
    struct dice dice = dice_new(2026);
    const double tolerances[] = {1e-2, 1e-4, 1e-5};
    for (int k = 0; k < repeats(40); k++) {
        const struct stack stack = random_stack(&dice);
        const bool diffuse = k % 5 == 0;
        const double angle = diffuse || k % 2 == 0 ? 0 : 1.5 * dice_uniform(&dice);
        struct cml_exact fine = solve(&stack, diffuse, angle, 1e-7);
        for (int i = 0; i < 3; i++) {
            struct cml_exact coarse = solve(&stack, diffuse, angle, tolerances[i]);
            for (int j = 0; j < fine.count; j++)
                assert_near("coarse", coarse.value[j], fine.value[j], coarse.error[j] + fine.error[j]);
            cml_exact_clear(&coarse);
        }
        cml_exact_clear(&fine);
    }
}

static void expect_refused(const struct cml_medium_def *media, int layers, double most_work)
{
    struct cml_exact_ray beam = {1, 1};
    const struct cml_exact_light light = {.num_beams = 1, .beam = &beam};
    const struct cml_exact_options options = {.tolerance = 1e-7, .most_work = most_work};
    struct cml_exact exact;
    struct cml_error err;
    assert_int_equal(cml_exact_solve(media, layers, &light, &options, &exact, &err), CML_E_NUMERIC);
    assert_null(exact.value);
}

/* A number of operations, not a clock, limits the work: the result does not depend on the machine. */
static void too_much_work_is_refused_or_cut_short(void **state)
{
    (void)state;
    const struct stack stack = slab(1.4, 0.1, 90, 0.95, 1);
    struct cml_exact_ray beam = {1, 1};
    const struct cml_exact_light light = {.num_beams = 1, .beam = &beam};
    const struct cml_exact_options some = {.tolerance = 1e-7, .most_work = 3e7};
    struct cml_exact exact;
    struct cml_error err;
    expect_refused(stack.media, 1, 1e5);
    require_ok(cml_exact_solve(stack.media, 1, &light, &some, &exact, &err), &err);
    assert_false(exact.converged);
    assert_true(cml_exact_worst(&exact) > 1e-7);
    cml_exact_clear(&exact);
}

/* Examining all directions for each of 200,000 indices would take many minutes. A signal ends the test after
 * one minute of processor time. */
static void indices_without_number_are_refused_at_once(void **state)
{
    enum { LAYERS = 200000 };
    (void)state;
    const struct itimerval minute = {.it_value = {.tv_sec = 60}}, never = {.it_value = {.tv_sec = 0}};
    struct cml_medium_def *media = calloc(LAYERS + 2, sizeof *media);
    assert_non_null(media);
    for (int m = 0; m < LAYERS + 2; m++)
        media[m] = (struct cml_medium_def){.n = 1 + 5e-7 * m, .mua = 1, .mus = 10, .d = 1};
    assert_int_equal(setitimer(ITIMER_VIRTUAL, &minute, NULL), 0);
    expect_refused(media, LAYERS, 1e9);
    assert_int_equal(setitimer(ITIMER_VIRTUAL, &never, NULL), 0);
    free(media);
}

static void numbers_beyond_double_precision_are_refused(void **state)
{
    (void)state;
    expect_refused(slab(1e200, 1, 10, 0.5, 1).media, 1, 1e11);
}

static double hg_density(double g, double c)
{
    return (1 - g * g) / 2 / pow(1 + g * g - 2 * g * c, 1.5);
}

/* Returns the density of phase function `of` at the cosine c (samples/manual/input/phase-functions.md). */
static double density(const struct cml_phase *of, double c)
{
    const double *n = of->number, g = n[0], a = n[1];
    if (of->kind == CML_PHASE_HG2) return n[2] * hg_density(g, c) + (1 - n[2]) * hg_density(a, c);
    if (of->kind == CML_PHASE_MHG) return a * hg_density(g, c) + (1 - a) * 1.5 * c * c;
    if (of->kind == CML_PHASE_RAYLEIGH) return 0.375 * (1 + c * c);
    if (of->kind == CML_PHASE_TABLE) return c > 0 ? 0.25 + c * 0.75 : 0.25 + c * -0.125;
    return 2 * a * g * pow(1 - g * g, 2 * a) / (pow(1 + g, 2 * a) - pow(1 - g, 2 * a)) /
           pow(1 + g * g - 2 * g * c, a + 1);
}

/* Compares sixty moments with integrals of the density by the midpoint rule, which errs by 2e-8. */
static void moments_are_those_of_the_density(void **state)
{
    (void)state;
    enum { COUNT = 60, STEPS = 600000 };
    double deflection[] = {0, 1, 2}, rows[] = {1, 0.25, 0.375}, below[3];
    struct cml_phase phases[] = {{.kind = CML_PHASE_HG2, .number = {0.8, -0.3, 0.7}},
                                 {.kind = CML_PHASE_MHG, .number = {0.7, 0.6}},
                                 {.kind = CML_PHASE_GK, .number = {0.6, 1.2}},
                                 {.kind = CML_PHASE_GK, .number = {-0.5, -0.3}},
                                 {.kind = CML_PHASE_RAYLEIGH},
                                 {.kind = CML_PHASE_TABLE, .rows = 3}};
    phases[5].deflection = deflection;
    phases[5].density = rows;
    phases[5].below = below;
    assert_true(cml_phase_scale_table(&phases[5]));
    for (size_t i = 0; i < sizeof phases / sizeof *phases; i++) {
        struct cml_error err;
        double sum[COUNT] = {0}, moment[COUNT];
        const struct cml_medium_def medium = {.g = cml_phase_mean(&phases[i]), .phase = &phases[i]};
        for (int k = 0; k < STEPS; k++) {
            const double c = 2 * (k + 0.5) / STEPS - 1, weight = density(&phases[i], c) * 2 / STEPS;
            double before = 0, p = 1;
            for (int l = 0; l < COUNT; l++) {
                const double next = ((2 * l + 1) * c * p - l * before) / (l + 1);
                sum[l] += weight * p;
                before = p;
                p = next;
            }
        }
        require_ok(cml_phase_moments(&medium, COUNT, moment, &err), &err);
        assert_near("mean", cml_phase_mean(&phases[i]), sum[1] / sum[0], 1e-8);
        for (int l = 0; l < COUNT; l++) assert_near("moment", moment[l], sum[l] / sum[0], 4e-8);
    }
}

/* Three parametrisations of Henyey and Greenstein's function give equal totals. */
static void equal_functions_have_equal_totals(void **state)
{
    (void)state;
    const struct cml_phase phases[] = {{.kind = CML_PHASE_HG2, .number = {0.9, 0.9, 0.3}},
                                       {.kind = CML_PHASE_MHG, .number = {0.9, 1}},
                                       {.kind = CML_PHASE_GK, .number = {0.9, 0.5}}};
    struct stack stack = slab(1.4, 1, 100, 0.9, 0.1);
    struct cml_exact law = solve(&stack, false, 0.5, 1e-6);
    for (int i = 0; i < 3; i++) {
        stack.media[1].phase = &phases[i];
        struct cml_exact exact = solve(&stack, false, 0.5, 1e-6);
        for (int k = 0; k < exact.count; k++) assert_near("total", exact.value[k], law.value[k], 1e-10);
        cml_exact_clear(&exact);
    }
    cml_exact_clear(&law);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slabs_agree_with_other_adding_doubling),
        cmocka_unit_test(stacks_agree_with_other_adding_doubling),
        cmocka_unit_test(plates_obey_fresnel_and_beer),
        cmocka_unit_test(plates_in_diffuse_light),
        cmocka_unit_test(specular_light_is_split_as_by_the_program),
        cmocka_unit_test(a_half_space_follows_chandrasekhar),
        cmocka_unit_test(extreme_anisotropy_has_closed_forms),
        cmocka_unit_test(transmission_is_reciprocal),
        cmocka_unit_test(a_layer_in_two_parts_is_the_same),
        cmocka_unit_test(layers_in_many_parts_absorb_the_same),
        cmocka_unit_test(limits_are_finite_and_keep_all_light),
        cmocka_unit_test(thick_slabs_lose_light_as_in_the_milne_problem),
        cmocka_unit_test(thick_slabs_are_two_halves),
        cmocka_unit_test(stated_errors_are_no_smaller_than_true_ones),
        cmocka_unit_test(too_much_work_is_refused_or_cut_short),
        cmocka_unit_test(indices_without_number_are_refused_at_once),
        cmocka_unit_test(numbers_beyond_double_precision_are_refused),
        cmocka_unit_test(moments_are_those_of_the_density),
        cmocka_unit_test(equal_functions_have_equal_totals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
