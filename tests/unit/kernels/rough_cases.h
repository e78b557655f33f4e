/* Cases of kernels/rough.h (scattering by rough boundaries), compiled once in float and once in double.
 * Functions are compared with long double, drawn normals and single events with quadrature over slopes,
 * whole events with reciprocity. SPDX-License-Identifier: MIT */
#include "lib/dice.h"

#include "rough.h"

#define PI 3.14159265358979323846
static const struct {
    enum cml_rough_kind kind;
    double alpha;
} surfaces[] = {{CML_ROUGH_GGX, 0.05},   {CML_ROUGH_GGX, 0.3},       {CML_ROUGH_GGX, 1},
                {CML_ROUGH_GGX, 2},      {CML_ROUGH_BECKMANN, 0.05}, {CML_ROUGH_BECKMANN, 0.3},
                {CML_ROUGH_BECKMANN, 1}, {CML_ROUGH_BECKMANN, 2}};
static const double err_rounding = sizeof(real) == 4 ? 1 : 1e-8; /* rounding in units of float's bounds */

static struct cml_rough rough_of(int i)
{
    return (struct cml_rough){(int)surfaces[i].kind, (real)surfaces[i].alpha};
}

/* Returns a direction at an angle (degrees) from the normal; above 90 degrees it goes down. */
static struct cml_vec at_angle(double degrees)
{
    return (struct cml_vec){(real)sin(degrees * PI / 180), 0, (real)cos(degrees * PI / 180)};
}

/* ---- functions ---- */

static void functions_of_the_error_integral_are_those_of_the_c_library(void **state)
{
    (void)state;
    for (int i = 0; i < 4000; i++) {
        const double x = i < 2000 ? i * 0.004 : 8 * pow(1.01, i - 2000), y = (i + 0.5) / 2000;
        const long double r = (real)x,
                          scaled = r < 100 ? expl(r * r) * erfcl(r)
                                           : 1 / (r * sqrtl(PI)) * (1 - (0.5L - 0.75L / r / r) / r / r);
        const double root = (double)cml_erfc_inverse((real)y);
        assert_near("erfcx", (double)(cml_erfcx((real)x) / scaled), 1, 5e-7 * err_rounding + 1e-10);
        assert_near("erfc of its inverse", (double)erfcl(root), (double)(real)y, 4e-7 * err_rounding + 1e-15);
    }
    for (int i = 0; i < 70; i++) { /* the tail, with an error of 1e-7 */
        const double y = pow(10, -0.1 * i - 0.1), root = (double)cml_erfc_inverse((real)y);
        assert_near("tail of erfc", (double)erfcl(root) / (double)(real)y, 1,
                    (1 + root * root) * 1e-6 * err_rounding);
    }
}

static void the_depth_from_the_other_side_keeps_its_digits(void **state)
{
    (void)state;
    for (int i = 0; i < 600; i++) {
        const double e = 1e-30 * pow(10, i * 0.053);
        const long double r = (real)e, exact = r < 1 ? -logl(-expm1l(-r)) : -log1pl(-expl(-r));
        const double found = (double)cml_other_depth((real)e);
        assert_true(isfinite(found) && found >= 0);
        if (exact > 1e-29) assert_near("depth", found / (double)exact, 1, 5e-7 * err_rounding + 1e-14);
    }
}

/* Returns the share of slopes below x that a direction w sees, by the formula at cml_rough_share. */
static long double share_below(long double wz, long double side, long double x)
{
    return side * expl(-x * x) / 2 + wz * sqrtl((long double)PI) * erfcl(-x) / 2;
}

static void slopes_of_beckmann_have_the_share_that_is_drawn(void **state)
{
    (void)state;
    for (int degrees = 1; degrees < 170; degrees++) {
        const real wz = (real)cos(degrees * PI / 180), side = (real)sin(degrees * PI / 180);
        const double allowed = degrees <= 120 ? 5e-7 : degrees <= 150 ? 5e-6 : 5e-5;
        for (int i = 0; i < 2000; i++) {
            const double tail = 6e-8 * pow(10, i % 500 / 100.0), even = (i + 0.5) / 2000;
            const real xi = (real)(i < 500 ? tail : i < 1000 ? 1 - tail : even);
            const long double x = cml_rough_slope(wz, side, xi), top = (long double)wz / side;
            const double found = (double)(share_below(wz, side, x) / share_below(wz, side, top));
            if (!(fabs(found - (double)xi) < allowed * err_rounding + 3e-10))
                fail_msg("%d degrees: share %.9g of the slope %g, expected %.9g", degrees, found, (double)x,
                         (double)xi);
        }
    }
}

/* ---- a surface seen from a direction ---- */

/* The slopes of a facet along x and y. The mean of a function over the facets that a packet sees uses
 * parts of equal projected area. */
struct slopes {
    double x, y;
};

static struct slopes slopes_of(int i, double share, double turn)
{
    const double a = surfaces[i].alpha, t = surfaces[i].kind == CML_ROUGH_GGX ? a * sqrt(share / (1 - share))
                                                                              : a * sqrt(-log1p(-share));
    return (struct slopes){t * cos(turn), t * sin(turn)};
}

/* Returns the part of a facet that a packet along v sees, -v.m D(m) / (m.z D); 0 from behind. */
static double seen(struct cml_vec v, struct slopes s)
{
    return fmax(0, (double)v.x * s.x + (double)v.y * s.y - (double)v.z);
}

/* Returns the mean of seen() over the azimuths of facets with slope t, in closed form. */
static double seen_of_ring(struct cml_vec v, double t)
{
    const double along = t * (double)v.x, z = (double)v.z;
    if (fabs(z) >= along) return z < 0 ? -z : 0;
    return (sqrt(along * along - z * z) - z * acos(z / along)) / PI;
}

/* The area that a packet sees of the whole surface is |v.z| |Lambda|. The quadrature substitutes share =
 * sin^2 q, so that the tail of ggx is smooth. */
static void lambda_is_the_projected_area(void **state)
{
    (void)state;
    const double angles[] = {1, 20, 45, 70, 85, 89.9, 90.1, 95, 120, 150, 179};
    for (int i = 0; i < COUNT(surfaces); i++)
        for (int k = 0; k < COUNT(angles); k++) {
            const struct cml_vec v = at_angle(angles[k]), up = {v.x, v.y, CML_FABS(v.z)};
            const int n = 20000;
            double sum = 0;
            for (int j = 0; j < n; j++) {
                const double q = (j + 0.5) / n * PI / 2, share = fmin(sin(q) * sin(q), 1 - 1e-16);
                sum += seen_of_ring(v, slopes_of(i, share, 0).x) * sin(2 * q) * PI / 2 / n;
            }
            const double lambda = (double)cml_rough_lambda(rough_of(i), up), z = fabs((double)v.z);
            const double expected = z * ((double)v.z > 0 ? lambda : 1 + lambda);
            if (fabs(expected - sum) > 3e-5 * sum + 1e-8)
                fail_msg("surface %d, %g degrees: %.9g, by quadrature %.9g", i, angles[k], expected, sum);
        }
}

enum { TURNS = 8, SHARES = 8 };

static int cell_of(int i, struct cml_vec m)
{
    const double t = hypot((double)m.x, (double)m.y) / (double)m.z / surfaces[i].alpha,
                 share = surfaces[i].kind == CML_ROUGH_GGX ? t * t / (1 + t * t) : -expm1(-t * t);
    const double turn = (atan2(-(double)m.y, -(double)m.x) / (2 * PI) + 1);
    const int row = (int)(share * SHARES), column = (int)(turn * TURNS) % TURNS;
    return (row < SHARES ? row : SHARES - 1) * TURNS + column;
}

/* Counts drawn normals in cells of slopes and compares them with quadrature over the facets that the packet
 * sees. Packets come from above and, after a reflection, from below the plane of the surface. Cells that are
 * hardly visible are joined. */
static void drawn_normals_are_those_that_are_seen(void **state)
{
    (void)state;
    const double angles[] = {
        150, 105, 70}; /* flight from the normal, in degrees; incidence at 30, 75 and 110 degrees */
    const int draws = repeats(800000);
    for (int i = 0; i < COUNT(surfaces); i++)
        for (int k = 0; k < COUNT(angles); k++) {
            const struct cml_vec v = at_angle(angles[k]);
            if (!((double)v.z < 0) && !(cml_rough_lambda(rough_of(i), v) > (real)1e-6)) continue;
            double expected[SHARES * TURNS + 1] = {0}, all = 0;
            long count[SHARES * TURNS + 1] = {0};
            const int fine = 20;
            for (int cell = 0; cell < SHARES * TURNS; cell++) {
                for (int a = 0; a < 20 * fine; a++)
                    for (int b = 0; b < fine; b++) {
                        const double q = 1 - (a + 0.5) / (20 * fine),
                                     share = (cell / TURNS + 1 - q * q) / SHARES;
                        expected[cell] +=
                            q * seen(v, slopes_of(i, fmin(share, 1 - 1e-16),
                                                  (cell % TURNS + (b + 0.5) / fine) / TURNS * 2 * PI));
                    }
                all += expected[cell];
            }
            struct dice dice = dice_new(77);
            for (int n = 0; n < draws; n++) {
                const uint32_t first = dice_word(&dice), second = dice_word(&dice);
                count[cell_of(i, cml_rough_normal(rough_of(i), v, first, second))]++;
            }
            int bins = 0;
            double rest = 0;
            long rest_count = 0;
            for (int cell = 0; cell < SHARES * TURNS; cell++) {
                const double wanted = expected[cell] / all * draws;
                if (wanted < 30) {
                    rest += wanted;
                    rest_count += count[cell];
                    continue;
                }
                expected[bins] = wanted;
                count[bins++] = count[cell];
            }
            if (rest > 5) {
                expected[bins] = rest;
                count[bins++] = rest_count;
            } else
                assert_true(rest_count < 30);
            char what[80];
            snprintf(what, sizeof what, "surface %d from %g degrees", i, 180 - angles[k]);
            assert_fits(what, count, expected, bins);
        }
}

/* ---- single events ---- */

/* Computes the shares of packets that leave after a single facet, reflected and refracted. It integrates
 * over the facets seen, with Smith's G2 / G1 as the chance to leave: (1 + Li) / (1 + Li + Lo) upwards, (1
 * + Li) B(1 + Li, 1 + Lo) downwards. The optics of a facet are those of rule P5 in long double. */
static void first_order(int i, double degrees, double n1, double n2, double *mirrored, double *through)
{
    const struct cml_vec v = at_angle(180 - degrees), up = {v.x, v.y, -v.z};
    const double li = (double)cml_rough_lambda(rough_of(i), up);
    const int n = 300, turns = 60;
    double all = 0;
    *mirrored = *through = 0;
    for (int j = 0; j < n; j++)
        for (int t = 0; t < turns; t++) {
            const double q = (j + 0.5) / n * PI / 2;
            const struct slopes s = slopes_of(i, fmin(sin(q) * sin(q), 1 - 1e-16), (t + 0.5) / turns * PI);
            const double weight = seen(v, s) * sin(2 * q), size = sqrt(1 + s.x * s.x + s.y * s.y);
            const double m[3] = {-s.x / size, -s.y / size, 1 / size},
                         c = -((double)v.x * m[0] + (double)v.z * m[2]);
            if (!(weight > 0)) continue;
            all += weight;
            const double square = 1 - n1 * n1 / n2 / n2 * (1 - c * c), ct = square > 0 ? sqrt(square) : 0;
            const double rs = (n1 * c - n2 * ct) / (n1 * c + n2 * ct),
                         rp = (n1 * ct - n2 * c) / (n1 * ct + n2 * c);
            const double R = square > 0 ? (rs * rs + rp * rp) / 2 : 1, along = n1 / n2 * c - ct;
            const struct cml_vec out = {(real)((double)v.x + 2 * c * m[0]), (real)(2 * c * m[1]),
                                        (real)((double)v.z + 2 * c * m[2])};
            const struct cml_vec beyond = {(real)(n1 / n2 * (double)v.x + along * m[0]), (real)(along * m[1]),
                                           (real) - (n1 / n2 * (double)v.z + along * m[2])};
            if (out.z > 0)
                *mirrored += weight * R * (1 + li) / (1 + li + (double)cml_rough_lambda(rough_of(i), out));
            if (R < 1 && beyond.z > 0) {
                const double lo = (double)cml_rough_lambda(rough_of(i), beyond);
                *through +=
                    weight * (1 - R) * (1 + li) * exp(lgamma(1 + li) + lgamma(1 + lo) - lgamma(2 + li + lo));
            }
        }
    *mirrored /= all;
    *through /= all;
}

static void packets_leave_after_one_facet_as_smiths_shadowing_says(void **state)
{
    (void)state;
    static const double cases[][3] = {{0, 1, 1.5}, {60, 1, 1.5}, {30, 1.5, 1}, {60, 1.4, 1}};
    const int packets = repeats(400000);
    for (int i = 1; i < COUNT(surfaces); i += i == 3 ? 2 : 1)
        for (int k = 0; k < COUNT(cases); k++) {
            const double *c = cases[k];
            const struct cml_vec u = {(real)sin(c[0] * PI / 180), 0, (real)cos(c[0] * PI / 180)},
                                 against = {0, 0, -1};
            double expected[2];
            long count[2] = {0, 0};
            first_order(i, c[0], c[1], c[2], &expected[0], &expected[1]);
            const struct cml_stream stream = {.key = {(cml_u32)(10 * i + k)}};
            for (int n = 0; n < packets; n++) {
                cml_u32 blocks = 0;
                const struct cml_rough_exit exit = cml_rough_event(
                    stream, (cml_u64)n, 0, &blocks, rough_of(i), u, against, (real)c[1], (real)c[2], NULL);
                assert_int_equal(blocks, exit.steps + 1);
                if (exit.steps == 1) count[exit.transmitted]++;
            }
            for (int j = 0; j < 2; j++) {
                const double p = expected[j],
                             z = ((double)count[j] / packets - p) / sqrt(p * (1 - p) / packets);
                if (fabs(z) > 4.5)
                    fail_msg("surface %d, case %d, %s: %g, expected %g, z = %g", i, k,
                             j ? "refracted" : "mirrored", (double)count[j] / packets, p, z);
            }
        }
}

/* ---- whole events ---- */

enum { RINGS = 6, BINS = 2 * RINGS };

/* Reciprocity: n1^2 W P is symmetric, where the bins of both sides have equal cosine-weighted solid angle
 * W. Its sums say that isotropic light on both sides stays isotropic. */
static void events_are_reciprocal(void **state)
{
    (void)state;
    static const double indices[][2] = {{1, 1.5}, {1.33, 1}, {1, 1.1}};
    const int packets = repeats(80000);
    double worst = 0, sum = 0;
    int pairs = 0;
    for (int i = 0; i < COUNT(surfaces); i++)
        for (int k = 0; k < COUNT(indices); k++) {
            double P[BINS][BINS] = {{0}};
            struct dice dice = dice_new((uint32_t)(100 + 10 * i + k));
            const struct cml_stream stream = {.key = {5, (cml_u32)(10 * i + k)}};
            for (int from = 0; from < BINS; from++)
                for (int n = 0; n < packets; n++) {
                    const int beyond = from / RINGS;
                    const double z = sqrt((from % RINGS + dice_uniform(&dice)) / RINGS),
                                 side = beyond ? 1 : -1;
                    const double turn = dice_between(&dice, 0, 2 * PI), s = sqrt(1 - z * z);
                    const struct cml_vec u = {(real)(s * cos(turn)), (real)(s * sin(turn)),
                                              (real)(-side * z)},
                                         against = {0, 0, (real)side};
                    cml_u32 blocks = 0;
                    const struct cml_rough_exit exit = cml_rough_event(
                        stream, (cml_u64)(from * packets + n), 0, &blocks, rough_of(i), u, against,
                        (real)indices[k][beyond], (real)indices[k][1 - beyond], NULL);
                    const double out = (double)exit.u.z, length = (double)cml_dot(exit.u, exit.u);
                    assert_near("length", length, 1, 8 * (double)CML_EPSILON);
                    assert_true(exit.steps < 200 && (out * side > 0) != exit.transmitted);
                    const int ring = (int)(fmin(out * out, 1 - 1e-12) * RINGS),
                              there = exit.transmitted ? !beyond : beyond;
                    P[from][there * RINGS + ring] += 1.0 / packets;
                }
            for (int a = 0; a < BINS; a++)
                for (int b = 0; b < a; b++) {
                    const double na = pow(indices[k][a / RINGS], 2), nb = pow(indices[k][b / RINGS], 2);
                    const double variance =
                        (na * na * P[a][b] * (1 - P[a][b]) + nb * nb * P[b][a] * (1 - P[b][a])) / packets;
                    if (P[a][b] * packets < 20 || P[b][a] * packets < 20) continue;
                    const double z = (na * P[a][b] - nb * P[b][a]) / sqrt(variance);
                    worst = fmax(worst, fabs(z));
                    sum += z * z;
                    pairs++;
                }
        }
    /* Sidak's limit for some 1000 pairs at 1e-4 is 5.33; the sum of squares is chi-square */
    if (!(worst < 5.33 && chi_square_p(sum, pairs) > 1e-4))
        fail_msg("chi-square %g of %d pairs, the worst z %g", sum, pairs, worst);
}

/* A backing reflects all directions; the weight kept is the product of its reflectances over all facets. */
static void a_backing_reflects_at_every_facet(void **state)
{
    (void)state;
    const struct cml_backing mirror = {.kind = CML_BACKING_MIRROR, .kept = (real)0.25};
    const struct cml_vec u = at_angle(50), against = {0, 0, -1};
    const struct cml_stream stream = {.key = {9}};
    long more = 0;
    for (int i = 0; i < COUNT(surfaces); i++)
        for (cml_u64 n = 0; n < 2000; n++) {
            cml_u32 blocks = 0;
            const struct cml_rough_exit exit =
                cml_rough_event(stream, n, 0, &blocks, rough_of(i), u, against, 1, 1, &mirror);
            assert_false(exit.transmitted);
            assert_near("what stays", (double)exit.stays, pow(0.75, exit.steps), 1e-6);
            more += exit.steps > 1;
        }
    assert_true(more > 1000);
}

/* Directions and normals that are horizontal, vertical or nearly so give finite unit vectors, on the side
 * that z says. */
static void extreme_directions_end(void **state)
{
    (void)state;
    static const double cosines[] = {1, 1e-3, 1e-6, 1e-10, 1e-20};
    static const double alphas[] = {1e-4, 1e-2, 2};
    for (int kind = CML_ROUGH_GGX; kind <= CML_ROUGH_BECKMANN; kind++)
        for (int a = 0; a < COUNT(alphas); a++)
            for (int k = 0; k < COUNT(cosines); k++)
                for (cml_u64 n = 0; n < 4000; n++) {
                    const struct cml_rough rough = {kind, (real)alphas[a]};
                    const double z = cosines[k];
                    const struct cml_vec u = {(real)sqrt(1 - z * z), 0, (real)z}, against = {0, 0, -1};
                    const struct cml_stream stream = {.key = {3}};
                    cml_u32 blocks = 0;
                    const struct cml_rough_exit exit =
                        cml_rough_event(stream, n, 0, &blocks, rough, u, against, (real)(n & 1 ? 1.5 : 1),
                                        (real)(n & 1 ? 1 : 1.5), NULL);
                    const double length = (double)cml_dot(exit.u, exit.u);
                    if (!(fabs(length - 1) < 16 * (double)CML_EPSILON) || exit.steps >= CML_ROUGH_LIMIT ||
                        (exit.u.z > 0) != exit.transmitted)
                        fail_msg("kind %d, alpha %g, cosine %g, packet %d: length %g, z %g, %d steps", kind,
                                 alphas[a], z, (int)n, length, (double)exit.u.z, exit.steps);
                }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(functions_of_the_error_integral_are_those_of_the_c_library),
        cmocka_unit_test(the_depth_from_the_other_side_keeps_its_digits),
        cmocka_unit_test(slopes_of_beckmann_have_the_share_that_is_drawn),
        cmocka_unit_test(lambda_is_the_projected_area),
        cmocka_unit_test(drawn_normals_are_those_that_are_seen),
        cmocka_unit_test(packets_leave_after_one_facet_as_smiths_shadowing_says),
        cmocka_unit_test(events_are_reciprocal),
        cmocka_unit_test(a_backing_reflects_at_every_facet),
        cmocka_unit_test(extreme_directions_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
