/* Cases of kernels/optics.h, compiled once in float and once in double: Fresnel reflectance, directions,
 * phase functions, optical depth. SPDX-License-Identifier: MIT */
#include "lib/dice.h"

#include <complex.h>

/* Random words for the redraws of the optical depth. They are scripted, because no seed reaches a word of
 * 0 in reasonable time. */
static uint32_t script[8];
static int script_length, script_read;
static enum cml_purpose script_purpose;

static struct cml_block scripted_draw(struct cml_stream stream, cml_u64 photon, enum cml_purpose purpose,
                                      cml_u32 event)
{
    struct cml_block block = cml_draw(stream, photon, purpose, event);
    script_purpose = purpose;
    for (int k = 0; k < 4 && k < script_length; k++) block.w[k] = script[k];
    script_read++;
    return block;
}
#define cml_draw scripted_draw
#include "optics.h"

#define PI 3.14159265358979323846
static const double eps = (double)CML_EPSILON;
static const double gs[] = {-1, -0.999, -0.5, 0, 1e-4, 0.5, 0.9, 0.999, 0.99999, 1};
static const double indices[] = {1, 1.0003, 1.33, 1.37, 1.5, 2.4, 4};

static double length(struct cml_vec v)
{
    return sqrt((double)v.x * (double)v.x + (double)v.y * (double)v.y + (double)v.z * (double)v.z);
}

static struct cml_vec vec(double x, double y, double z)
{
    const struct cml_vec v = {(real)x, (real)y, (real)z};
    return v;
}

static double dot(struct cml_vec a, struct cml_vec b)
{
    return (double)a.x * (double)b.x + (double)a.y * (double)b.y + (double)a.z * (double)b.z;
}

/* ---- Fresnel ---- */

/* Returns the reflectance computed from the angles [Hecht, Optics, eqs 4.34-4.47]; ci: cosine of
 * incidence, 0..1. *ct: cosine of refraction. */
static long double fresnel_by_angles(long double n1, long double n2, long double ci, long double *ct)
{
    const long double si = sqrtl((1 - ci) * (1 + ci)), st = n1 / n2 * si;
    *ct = 0;
    if (st >= 1) return 1;
    const long double a = atan2l(si, ci), b = asinl(st);
    *ct = cosl(b);
    if (a < 1e-9L) return powl((n1 - n2) / (n1 + n2), 2);
    return 0.5L * (powl(sinl(a - b) / sinl(a + b), 2) + powl(tanl(a - b) / tanl(a + b), 2));
}

/* Checks the reflectance at one cosine. R has an infinite slope at the critical angle, so the bound also
 * allows the values at cosines a few roundings away. */
static void check_fresnel(double n1, double n2, double cosine)
{
    const real rn1 = (real)n1, rn2 = (real)n2, ci = (real)cosine;
    real ct;
    const double R = (double)cml_fresnel(rn1, rn2, ci, &ct);
    const double bound = sizeof(real) == 4 ? 1e-6 : 1e-14;
    const double ratio = n1 / n2, blur = 2 * eps * fmax(1, 1 / (ratio * ratio)) / fmax((double)ci, 1e-300);
    long double exact_ct, low_ct, high_ct;
    const long double exact = fresnel_by_angles(rn1, rn2, ci, &exact_ct);
    const long double low = fresnel_by_angles(rn1, rn2, fmax(0, (double)ci - blur), &low_ct);
    const long double high = fresnel_by_angles(rn1, rn2, fmin(1, (double)ci + blur), &high_ct);
    const double slack = (double)(fabsl(low - exact) + fabsl(high - exact)) + bound;
    if (!(fabs(R - (double)exact) <= slack && R >= 0 && R <= 1))
        fail_msg("R(%g, %g, %.17g) = %.17g, exact %.17Lg", n1, n2, (double)ci, R, exact);
    const double slack_ct = (double)(fabsl(low_ct - exact_ct) + fabsl(high_ct - exact_ct)) + bound;
    if (!(fabs((double)ct - (double)exact_ct) <= slack_ct))
        fail_msg("ct(%g, %g, %.17g) = %.17g, exact %.17Lg", n1, n2, (double)ci, (double)ct, exact_ct);
}

static void fresnel_agrees_with_the_formula_in_angles(void **state)
{
    (void)state;
    for (int i = 0; i < COUNT(indices); i++)
        for (int j = 0; j < COUNT(indices); j++) {
            if (i == j) continue;
            for (int k = 0; k <= 2000; k++) check_fresnel(indices[i], indices[j], k / 2000.0);
            const double grazing[] = {1e-300, 1e-30, 1e-12, 1e-7, 1e-6, 1e-4, 1 - 1e-7, 1 - 1e-15};
            for (int k = 0; k < COUNT(grazing); k++) check_fresnel(indices[i], indices[j], grazing[k]);
            if (indices[i] < indices[j]) continue;
            const double critical = asin(indices[j] / indices[i]);
            for (int k = -20; k <= 20; k++) check_fresnel(indices[i], indices[j], cos(critical + 1e-7 * k));
        }
}

static void fresnel_at_normal_incidence_is_the_textbook_number(void **state)
{
    (void)state;
    real ct;
    assert_near("R", (double)cml_fresnel(1, (real)1.5, 1, &ct), 0.04, eps);
    assert_near("R", (double)cml_fresnel((real)1.37, 1, 1, &ct), 0.37 * 0.37 / (2.37 * 2.37), 2 * eps);
    assert_true(ct == 1);
}

/* Compares the reflectance of a metal with the amplitudes of a complex index at all angles. With K = 0 it
 * equals the formula of a dielectric, and matched indices do not give 0 / 0. */
static void a_metal_reflects_by_its_complex_index(void **state)
{
    (void)state;
    static const double metals[][2] = {{0.183, 3.434}, {1.373, 7.618}, {3.9, 0.02}, {0.05, 0.3}, {1, 1}};
    real ct;
    for (size_t m = 0; m < sizeof metals / sizeof *metals; m++)
        for (int i = 1; i <= 1000; i++) {
            const long double c = i / 1000.0L, s2 = 1 - c * c;
            const long double complex index = metals[m][0] + metals[m][1] * 1.0iL,
                                      ct2 = csqrtl(1 - s2 / (index * index)),
                                      rs = (c - index * ct2) / (c + index * ct2),
                                      rp = (index * c - ct2) / (index * c + ct2);
            const double R = (double)((powl(cabsl(rs), 2) + powl(cabsl(rp), 2)) / 2);
            assert_near("R", (double)cml_metal_reflectance((real)metals[m][0], (real)metals[m][1], (real)c),
                        R, 60 * eps);
        }
    for (int i = 0; i <= 100; i++) {
        const real c = (real)(i / 100.0), R = cml_metal_reflectance((real)1.5, 0, c);
        assert_near("R", (double)R, (double)cml_fresnel(1, (real)1.5, c, &ct), 60 * eps);
        const real matched = cml_metal_reflectance(1, 0, c);
        assert_true(matched >= 0 && matched <= 1);
    }
}

static void total_reflection_is_exactly_one(void **state)
{
    (void)state;
    struct dice dice = dice_new(21);
    for (int n = 0; n < 200000; n++) {
        const double n1 = dice_between(&dice, 1.001, 4), n2 = dice_between(&dice, 1, n1 - 0.0005);
        const double critical = sqrt((n1 - n2) * (n1 + n2)) / n1;
        real ct = -1;
        assert_true(cml_fresnel((real)n1, (real)n2, (real)dice_between(&dice, 0, critical * 0.99), &ct) == 1);
        assert_true(ct == 0);
    }
}

/* The reflectance along a ray is the same in both directions. */
static void the_reflectance_is_symmetric(void **state)
{
    (void)state;
    struct dice dice = dice_new(22);
    for (int n = 0; n < 200000; n++) {
        const real n1 = (real)dice_between(&dice, 1, 4), n2 = (real)dice_between(&dice, 1, 4);
        real ct, back;
        const real R = cml_fresnel(n1, n2, (real)dice_between(&dice, 0.05, 1), &ct);
        if (!(ct > (real)0.05)) continue;
        assert_near("R back", (double)cml_fresnel(n2, n1, ct, &back), (double)R, 500 * eps);
    }
}

/* ---- reflection and refraction of directions ---- */

/* Checks reflection and refraction of a random direction that meets a random normal at this angle (rad). */
static void check_refraction(struct dice *dice, double n1, double n2, double angle)
{
    double m[3], e[3];
    dice_direction(dice, m);
    dice_direction(dice, e);
    for (int pass = 0; pass < 2; pass++) {
        const double along = m[0] * e[0] + m[1] * e[1] + m[2] * e[2];
        for (int k = 0; k < 3; k++) e[k] -= along * m[k];
        const double scale = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
        for (int k = 0; k < 3; k++) e[k] /= scale;
    }
    const double s = sin(angle), c = cos(angle);
    const struct cml_vec normal = vec(m[0], m[1], m[2]), across = vec(e[0], e[1], e[2]);
    const struct cml_vec u = vec(s * e[0] - c * m[0], s * e[1] - c * m[1], s * e[2] - c * m[2]);
    const real ci = -cml_dot(u, normal);
    const struct cml_vec mirrored = cml_reflect(u, normal);
    assert_near("mirrored across", dot(mirrored, across), s, 8 * eps);
    assert_near("mirrored along", dot(mirrored, normal), c, 8 * eps);
    assert_near("mirrored length", length(mirrored), 1, 4 * eps);
    real ct;
    if (cml_fresnel((real)n1, (real)n2, ci, &ct) == 1) return;
    const struct cml_vec refracted = cml_refract(u, normal, (real)n1 / (real)n2, ci, ct);
    assert_near("Snell", dot(refracted, across), n1 / n2 * s, 40 * eps);
    assert_true(dot(refracted, normal) < 0);
    assert_near("cosine", -dot(refracted, normal), (double)ct, 40 * eps);
    assert_near("refracted length", length(refracted), 1, 4 * eps);
}

static void directions_obey_snell_and_the_mirror(void **state)
{
    (void)state;
    struct dice dice = dice_new(23);
    static const double pairs[][2] = {{1, 1.4}, {1.4, 1}, {1, 4}, {1.5, 1.33}};
    for (int n = 0; n < 2000; n++)
        for (int i = 0; i < COUNT(pairs); i++) {
            const double critical = asin(fmin(1, pairs[i][1] / pairs[i][0]));
            const double angles[] = {
                0, PI / 4, PI / 180 * 89.9, fmin(critical, 1.5) - 1e-3, 1e-4, dice_between(&dice, 0, 1.5)};
            for (int k = 0; k < COUNT(angles); k++)
                check_refraction(&dice, pairs[i][0], pairs[i][1], angles[k]);
        }
}

/* The ratio of indices squared enlarges the rounding of the cosine of incidence. */
static void any_ratio_of_indices_gives_a_direction(void **state)
{
    (void)state;
    struct dice dice = dice_new(29);
    for (int n = 0; n < 20000; n++) {
        const double ratio = pow(10, dice_between(&dice, -4, 4));
        const double s = dice_uniform(&dice) / fmax(1, ratio), a = dice_between(&dice, 0, 2 * PI);
        const struct cml_vec normal = {0, 0, -1}, u = vec(s * cos(a), s * sin(a), sqrt(1 - s * s));
        real ct;
        if (cml_fresnel((real)ratio, 1, u.z, &ct) == 1) continue;
        assert_near("length", length(cml_refract(u, normal, (real)ratio, u.z, ct)), 1, 8 * eps);
    }
}

static void normal_incidence_goes_straight_on(void **state)
{
    (void)state;
    const struct cml_vec u = {0, 0, 1}, normal = {0, 0, -1};
    real ct;
    cml_fresnel(1, (real)1.4, 1, &ct);
    const struct cml_vec on = cml_refract(u, normal, (real)1 / (real)1.4, 1, ct),
                         back = cml_reflect(u, normal);
    assert_true(on.x == 0 && on.y == 0 && fabs((double)on.z - 1) <= eps);
    assert_true(back.x == 0 && back.y == 0 && back.z == -1);
}

/* ---- Henyey-Greenstein ---- */

/* Computes the deflection as cml_scatter does. */
static void deflect(real g, real s, real *cosine, real *sine)
{
    real per_square, unused;
    cml_reciprocals(cml_deflection_square(g, s), 1, &per_square, &unused);
    cml_henyey_greenstein(g, s, per_square, cosine, sine);
}

/* Returns the inverted distribution [eq. 3.22] in long double; a negative g gives the mirror image. */
static long double inverted_cosine(long double g, long double s)
{
    const long double size = fabsl(g), d = 1 + size * s;
    const long double c = size < 1e-3L ? s + 1.5L * size * (1 - s * s)
                                       : (1 + size * size - powl((1 - size * size) / d, 2)) / (2 * size);
    return g < 0 ? -c : c;
}

static void check_deflection(double g, uint32_t word)
{
    const real rg = (real)g, s = cml_uniform_symmetric(word);
    real c, sine;
    deflect(rg, s, &c, &sine);
    const double tolerance =
        8 * eps + (fabs(g) < 1e-3 ? 4e-8 : 0) + (fabs(g) < 1 ? 1e-17 / (1 - fabs(g)) : 0);
    if (fabs(g) < 1) assert_near("cosine", (double)c, (double)inverted_cosine(rg, s), tolerance);
    assert_true(c >= -1 && c <= 1);
    assert_true(sine >= 0 && (double)sine <= 1 + 4 * eps);
    assert_near("cos^2 + sin^2", (double)c * (double)c + (double)sine * (double)sine, 1, 8 * eps);
}

static void deflections_are_those_of_the_inverted_distribution(void **state)
{
    (void)state;
    struct dice dice = dice_new(24);
    static const uint32_t edges[] = {0, 256, 512, 0x7fffff00u, 0x80000000u, 0xffffff00u, 0xfffffe00u};
    for (int i = 0; i < COUNT(gs); i++) {
        for (int k = 0; k < COUNT(edges); k++) check_deflection(gs[i], edges[k]);
        for (int n = 0; n < 50000; n++) check_deflection(gs[i], dice_word(&dice));
        for (uint32_t n = 0; n < 20000; n++) check_deflection(gs[i], n << 8);
        for (uint32_t n = 0; n < 20000; n++) check_deflection(gs[i], 0xffffffffu - (n << 8));
    }
}

static void g_of_plus_or_minus_one_is_exactly_forward_or_backward(void **state)
{
    (void)state;
    struct dice dice = dice_new(25);
    for (int n = 0; n < 100000; n++) {
        const real s = cml_uniform_symmetric(n < 2 ? 0xffffffffu * (unsigned)n : dice_word(&dice));
        real c, sine;
        deflect(1, s, &c, &sine);
        assert_true(c == 1 && sine == 0);
        deflect(-1, s, &c, &sine);
        assert_true(c == -1 && sine == 0);
        deflect(0, s, &c, &sine);
        assert_near("isotropic", (double)c, (double)s, eps);
    }
}

/* The first two Legendre moments are g and g^2, by the midpoint rule over the uniform. */
static void the_mean_cosine_is_g_and_the_second_moment_g_squared(void **state)
{
    (void)state;
    enum { points = 1 << 18 };
    for (int i = 0; i < COUNT(gs); i++) {
        double first = 0, second = 0;
        for (uint32_t n = 0; n < points; n++) {
            real c, s;
            deflect((real)gs[i], cml_uniform_symmetric((n << 14) + (1u << 13)), &c, &s);
            first += (double)c;
            second += 1.5 * (double)c * (double)c - 0.5;
        }
        const double tolerance = fabs(gs[i]) > 0.9999 && fabs(gs[i]) < 1 ? 2e-5 : 2e-6;
        assert_near("first moment", first / points, gs[i], tolerance);
        assert_near("second moment", second / points, gs[i] * gs[i], tolerance);
    }
}

/* Returns P(cos < mu), the integral of eq. 3.21. */
static double below_cosine(double g, double mu)
{
    if (g == 0) return (1 + mu) / 2;
    return (1 - g * g) / (2 * g) * (1 / sqrt(1 + g * g - 2 * g * mu) - 1 / (1 + g));
}

/* Returns the cosine with more digits near +-1, computed from the sine. */
static double sharp_cosine(double c, double s)
{
    return c > 0 ? 1 - s * s / (1 + c) : s * s / (1 - c) - 1;
}

static void cosines_follow_henyey_and_greenstein(void **state)
{
    (void)state;
    struct dice dice = dice_new(26);
    enum { bins = 50, samples = 200000 };
    static const double some[] = {-0.999, -0.6, 0, 0.3, 0.9, 0.999};
    for (int i = 0; i < COUNT(some); i++) {
        const double g = some[i];
        long count[bins] = {0};
        double edge[bins + 1], expected[bins];
        /* bins narrow towards the peak, so that each holds many samples */
        for (int b = 0; b <= bins; b++) {
            const double x = 2.0 * b / bins - 1, d = 1 + g * x;
            edge[b] = g == 0 ? x : (1 + g * g - pow((1 - g * g) / d, 2)) / (2 * g);
        }
        for (int b = 0; b < bins; b++)
            expected[b] = samples * (below_cosine(g, edge[b + 1]) - below_cosine(g, edge[b]));
        for (int n = 0; n < samples; n++) {
            real c, s;
            deflect((real)g, cml_uniform_symmetric(dice_word(&dice)), &c, &s);
            const double sharp = sharp_cosine((double)c, (double)s);
            int b = 0;
            while (b + 1 < bins && sharp >= edge[b + 1]) b++;
            count[b]++;
        }
        assert_fits("cosine", count, expected, bins);
    }
}

/* ---- scattered directions ---- */

static struct cml_vec deflected(struct cml_vec u, real ct, real st, real cp, real sp)
{
    real unused, per_divisor;
    cml_reciprocals(1, cml_frame_divisor(u), &unused, &per_divisor);
    return cml_deflect(u, per_divisor, ct, st, cp, sp);
}

static const double starts[][3] = {
    {0, 0, 1},        {0, 0, -1},        {1, 0, 0},     {0, 1, 0},    {0.6, 0.8, 0},      {1e-4, 0, 1},
    {1e-4, 1e-4, -1}, {1e-20, 1e-20, 1}, {0, 1, -1e-9}, {0, 1, 1e-9}, {1e-20, 1e-20, -1}, {0.3, -0.5, 0.4},
};

static struct cml_vec start(int i)
{
    const double *s = starts[i], k = 1 / sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    return vec(k * s[0], k * s[1], k * s[2]);
}

/* Rotations by the azimuths 0 and 90 degrees give directions perpendicular to the old one and to each
 * other. */
static void a_deflection_is_an_isometry(void **state)
{
    (void)state;
    struct dice dice = dice_new(27);
    for (int n = 0; n < 20000; n++) {
        struct cml_vec u = start(n % COUNT(starts));
        if (n >= COUNT(starts) * 10) {
            double d[3];
            dice_direction(&dice, d);
            u = vec(d[0], d[1], d[2]);
        }
        const struct cml_vec a = deflected(u, 0, 1, 1, 0), b = deflected(u, 0, 1, 0, 1);
        assert_near("a.u", dot(a, u), 0, 6 * eps);
        assert_near("b.u", dot(b, u), 0, 6 * eps);
        assert_near("a.b", dot(a, b), 0, 6 * eps);
        const double theta = dice_between(&dice, 0, PI);
        real c, s;
        cml_circle_point(dice_word(&dice), &c, &s);
        const struct cml_vec v = deflected(u, (real)cos(theta), (real)sin(theta), c, s);
        assert_near("deflection", dot(v, u), cos(theta), 6 * eps);
        assert_near("azimuth", dot(v, a), sin(theta) * (double)c, 6 * eps);
        assert_near("azimuth", dot(v, b), sin(theta) * (double)s, 6 * eps);
        assert_near("length", length(v), 1, 4 * eps);
    }
}

static void a_direction_stays_a_unit_vector_over_a_million_events(void **state)
{
    (void)state;
    struct dice dice = dice_new(28);
    static const double some[] = {0, 0.9, 0.999, 0.99999};
    for (int i = 0; i < COUNT(some); i++) {
        struct cml_vec u = {0, 0, 1};
        double worst = 0;
        for (int n = 0; n < 1000000; n++) {
            const uint32_t word = dice_word(&dice);
            u = cml_scatter(u, (real)some[i], word, word * 2654435761u);
            worst = fmax(worst, fabs(dot(u, u) - 1));
        }
        assert_near("| |u|^2 - 1 |", worst, 0, 1e-6);
    }
}

static void azimuths_are_uniform_about_any_direction(void **state)
{
    (void)state;
    struct dice dice = dice_new(29);
    for (int i = 0; i < COUNT(starts); i++) {
        const struct cml_vec u = start(i);
        const struct cml_vec a = fabs((double)u.x) < 0.5 ? vec(1, 0, 0) : vec(0, 1, 0);
        const struct cml_vec e = cml_along(a, -cml_dot(a, u), u);
        const struct cml_vec f = {u.y * e.z - u.z * e.y, u.z * e.x - u.x * e.z, u.x * e.y - u.y * e.x};
        long count[64] = {0};
        for (int n = 0; n < 64000; n++) {
            real c, s;
            cml_circle_point(dice_word(&dice), &c, &s);
            const struct cml_vec v = deflected(u, (real)0.8, (real)0.6, c, s);
            const double phi = atan2(dot(v, f) / length(f), dot(v, e) / length(e));
            count[(int)((phi / (2 * PI) + 0.5) * 64) & 63]++;
        }
        assert_flat("azimuth", count, 64);
    }
}

/* ---- optical depth ---- */

static double depth_of(uint64_t photon, uint32_t event, uint32_t word)
{
    const struct cml_stream stream = {.key = {5u, 0u, 0u, 0u}};
    return (double)cml_optical_depth(stream, photon, event, word);
}

static void optical_depths_are_exponential_with_mean_one(void **state)
{
    (void)state;
    struct dice dice = dice_new(30);
    enum { bins = 64, samples = 200000 };
    long count[bins] = {0};
    double sum = 0;
    for (int n = 0; n < samples; n++) {
        const double tau = depth_of(1, 1, dice_word(&dice));
        assert_true(tau >= 0);
        count[(int)(exp(-tau) * bins * (1 - 1e-9))]++;
    }
    assert_flat("optical depth", count, bins);
    for (uint32_t n = 0; n < 1u << 18; n++) sum += depth_of(1, 1, (n << 14) + (1u << 13));
    assert_near("mean", sum / (1 << 18), 1, 2e-6); /* the midpoint rule misses ln 2 / 2 of a cell */
}

/* The number of words that give more than a depth follows the exponential, up to the last word. */
static void the_tail_beyond_sixteen_mean_free_paths_is_there(void **state)
{
    (void)state;
    for (uint32_t word = 1; word < 500; word++)
        assert_near("depth", depth_of(1, 1, word), -log((word + 0.5) * 0x1p-32), 22 * eps);
}

/* A word of 0 stands for any depth beyond 32 ln 2. The rest of the depth is exponential again and has
 * random words of its own. */
static void beyond_the_last_word_the_depth_has_no_memory(void **state)
{
    (void)state;
    enum { bins = 64, samples = 64000 };
    long count[bins] = {0};
    for (uint32_t n = 0; n < samples; n++) {
        const double rest = depth_of(n % 251, n / 251, 0) - 32 * log(2.0);
        assert_true(rest >= -64 * eps);
        count[(int)(exp(-fmax(0, rest)) * bins * (1 - 1e-9))]++;
    }
    assert_flat("redrawn depth", count, bins);
    assert_int_equal(script_purpose, CML_PURPOSE_TAIL);
}

static void redraws_of_zero_add_up_and_come_to_an_end(void **state)
{
    (void)state;
    const double cell = 32 * log(2.0);
    static const uint32_t one[] = {0x80000000u}, two[] = {0, 0x80000000u}, none[] = {0, 0, 0, 0};
    const double half = -log(0.5 + 0x1p-33);
    memcpy(script, one, sizeof one);
    script_length = 1;
    assert_near("one redraw", depth_of(1, 1, 0), cell + half, 64 * eps);
    memcpy(script, two, sizeof two);
    script_length = 2;
    assert_near("two redraws", depth_of(1, 1, 0), 2 * cell + half, 128 * eps);
    memcpy(script, none, sizeof none);
    script_length = 4;
    script_read = 0;
    assert_near("all zero", depth_of(1, 1, 0), 4 * cell + 33 * log(2.0), 256 * eps);
    assert_int_equal(script_read, 4);
    script_length = 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fresnel_agrees_with_the_formula_in_angles),
        cmocka_unit_test(fresnel_at_normal_incidence_is_the_textbook_number),
        cmocka_unit_test(a_metal_reflects_by_its_complex_index),
        cmocka_unit_test(total_reflection_is_exactly_one),
        cmocka_unit_test(the_reflectance_is_symmetric),
        cmocka_unit_test(directions_obey_snell_and_the_mirror),
        cmocka_unit_test(any_ratio_of_indices_gives_a_direction),
        cmocka_unit_test(normal_incidence_goes_straight_on),
        cmocka_unit_test(deflections_are_those_of_the_inverted_distribution),
        cmocka_unit_test(g_of_plus_or_minus_one_is_exactly_forward_or_backward),
        cmocka_unit_test(the_mean_cosine_is_g_and_the_second_moment_g_squared),
        cmocka_unit_test(cosines_follow_henyey_and_greenstein),
        cmocka_unit_test(a_deflection_is_an_isometry),
        cmocka_unit_test(a_direction_stays_a_unit_vector_over_a_million_events),
        cmocka_unit_test(azimuths_are_uniform_about_any_direction),
        cmocka_unit_test(optical_depths_are_exponential_with_mean_one),
        cmocka_unit_test(the_tail_beyond_sixteen_mean_free_paths_is_there),
        cmocka_unit_test(beyond_the_last_word_the_depth_has_no_memory),
        cmocka_unit_test(redraws_of_zero_add_up_and_come_to_an_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
