/* Compares spheres and cylinders that are small beside the spacing of single precision at their place with
 * the same bodies in double precision near the frame's origin, and with Fresnel's equations.
 * SPDX-License-Identifier: MIT */
#include "flight.h"

#include "lib/dice.h"

#include <float.h>
#include <math.h>

/* Half the width of a body [cm]: ROUNDINGS units of single precision at a depth of 0.5 cm. */
#define DEPTH 0.5
#define ROUNDINGS 33
static const double small = ROUNDINGS * FLT_EPSILON * DEPTH;

/* Counts of the fates of packets, and the mean of their absorbed weight with its error. */
struct ends {
    int fates[CML_NUM_FATES];
    double events, absorbed, err_absorbed;
};

static struct cml_fate_record *fly_all(const char *text, const char *engine, int photons)
{
    struct cml_error err;
    struct flight flight;
    const struct flight_options with = {.engine = engine, .kind = CML_SURFACE_AUTO};
    struct cml_fate_record *records = malloc((size_t)photons * sizeof *records);
    assert_non_null(records);
    flight_open(text, &with, &flight);
    require_ok(flight.engine->fates(flight.self, 0, (uint64_t)photons, records, &err), &err);
    flight_close(&flight);
    return records;
}

static struct ends ends_of(const char *text, const char *engine, int photons)
{
    struct cml_fate_record *records = fly_all(text, engine, photons);
    struct ends ends = {0};
    double squares = 0;
    for (int i = 0; i < photons; i++) {
        ends.fates[records[i].fate]++;
        ends.events += (double)records[i].boundary_events / photons;
        ends.absorbed += records[i].absorbed / photons;
        squares += records[i].absorbed * records[i].absorbed / photons;
    }
    ends.err_absorbed = sqrt((squares - ends.absorbed * ends.absorbed) / photons);
    free(records);
    return ends;
}

enum form { CYLINDERS, SPHERES, COATED };

/* Writes a scene: 7 x 7 bodies of n 1.5 at random places around a depth, in a clear layer, below a beam as
 * wide as they are. mut: optical depth of a body over half its width. The core of a coated sphere is clear.
 */
static void small_bodies_text(char *text, enum form form, double depth, double mut)
{
    const double r = small, mua = 0.3 * mut / r, mus = 0.7 * mut / r;
    struct dice dice = dice_new(3);
    char *at =
        text + sprintf(text,
                       "1.0\n1\nsmall A\n1000\n0.01 0.01\n10 10 1\nbeam disk %.9g\n1\n1\n1 0 0 0 %.9g\n",
                       14 * r, 2 * depth);
    for (int i = 0; i < 49; i++) {
        const double x = (4 * (i % 7) - 12 + dice_between(&dice, 0, 1)) * r,
                     y = (4 * (i / 7) - 12 + dice_between(&dice, 0, 1)) * r,
                     z = depth + r * dice_between(&dice, 0, 1), lean = r * (dice_between(&dice, 0, 1) - 0.5);
        if (form != CYLINDERS)
            at += sprintf(at, "i sphere %.12g %.12g %.12g %.9g", x, y, z, form == COATED ? 1.1 * r : r);
        else
            at += sprintf(at, "i cylinder %.12g %.12g %.12g %.12g %.12g %.12g %.9g", x - r, y, z - lean,
                          x + r, y, z + lean, r);
        at += sprintf(at, " 1.5 %.9g %.9g 0.5\n", mua, mus);
        if (form == COATED) at += sprintf(at, "i sphere %.12g %.12g %.12g %.9g 2.5 0 0 0\n", x, y, z, r);
    }
    sprintf(at, "1\n");
}

/* Tests that light that runs round in a small body far from the frame's origin stays on its chord: no packet
 * freezes, and none is caught that could not be. In double precision, the same bodies lie where no
 * coordinate is large. */
static void small_bodies_hold_their_light_as_large_ones_do(void **state)
{
    (void)state;
    static const double muts[] = {0, 0.01, 0.7};
    static const char *const names[] = {"cylinders", "spheres", "coated spheres"};
    static char text[16384];
    const int photons = 200000;
    for (enum form form = CYLINDERS; form <= COATED; form++)
        for (size_t i = 0; i < sizeof muts / sizeof *muts; i++) {
            small_bodies_text(text, form, DEPTH, muts[i]);
            const struct ends cpu = ends_of(text, "cpu", photons);
            small_bodies_text(text, form, 4 * small, muts[i]);
            const struct ends oracle = ends_of(text, "reference", photons);
            print_message("%s, mut r %g: events %.4f, %.4f in double; absorbed %.6f, %.6f +- %.6f; lost %d, "
                          "trapped %d\n",
                          names[form], muts[i], cpu.events, oracle.events, cpu.absorbed, oracle.absorbed,
                          oracle.err_absorbed, cpu.fates[CML_FATE_LOST], cpu.fates[CML_FATE_TRAPPED]);
            assert_int_equal(cpu.fates[CML_FATE_LOST] + cpu.fates[CML_FATE_TRAPPED], 0);
            assert_true(fabs(cpu.events - oracle.events) < 0.1 * oracle.events);
            assert_true(fabs(cpu.absorbed - oracle.absorbed) <=
                        4 * hypot(cpu.err_absorbed, oracle.err_absorbed));
            const double p = (double)oracle.fates[CML_FATE_REFLECTED] / photons;
            assert_true(fabs((double)cpu.fates[CML_FATE_REFLECTED] / photons - p) <
                        4 * sqrt(2 * p * (1 - p) / photons));
        }
}

/* Returns the reflectance for unpolarised light that falls from index 1 onto index n with the cosine ci. */
static double fresnel(double ci, double n)
{
    const double ct = sqrt(1 - (1 - ci * ci) / (n * n)), s = (ci - n * ct) / (ci + n * ct),
                 p = (n * ci - ct) / (n * ci + ct);
    return 0.5 * (s * s + p * p);
}

/* Tests parallel light on a clear sphere of n 1.5 that meets all of it, so that the square of the cosine of
 * incidence is uniform.
 *
 * The share R is reflected, and (1 - R)^2 R^(k - 1) leaves after the k-th chord, because the angle inside
 * equals that of the refraction on the way in. */
static void a_small_clear_sphere_shares_light_as_fresnel_has_it(void **state)
{
    (void)state;
    enum { CHORDS = 4 };
    const int photons = 400000, steps = 100000;
    double expected[CHORDS + 1] = {0}, found[CHORDS + 1] = {0};
    char text[512];
    for (int i = 0; i < steps; i++) {
        const double R = fresnel(sqrt((i + 0.5) / steps), 1.5);
        expected[0] += R / steps;
        for (int k = 1; k <= CHORDS; k++) expected[k] += (1 - R) * (1 - R) * pow(R, k - 1) / steps;
    }
    snprintf(text, sizeof text,
             "1.0\n1\nclear A\n1000\n0.01 0.01\n10 10 1\nbeam disk %.9g\n1\n1\n1 0 0 0 1\n"
             "i sphere 0 0 %.9g %.9g 1.5 0 0 0\n1\n",
             small, DEPTH, small);
    struct cml_fate_record *records = fly_all(text, "cpu", photons);
    for (int i = 0; i < photons; i++) {
        const int chords = (int)records[i].boundary_events - 2; /* every packet crosses one plane on its way
                                                                 * in and one on its way out */
        assert_true(records[i].fate == CML_FATE_TRANSMITTED || records[i].fate == CML_FATE_REFLECTED);
        if (chords >= 0 && chords <= CHORDS) found[chords] += 1.0 / photons;
    }
    free(records);
    for (int k = 0; k <= CHORDS; k++)
        print_message("%d chords: %.6f, on paper %.6f\n", k, found[k], expected[k]);
    assert_true(fabs(found[0] - expected[0]) < 4 * sqrt(expected[0] / photons));
    for (int k = 1; k <= CHORDS; k++)
        assert_true(fabs(found[k] - expected[k]) < 4 * sqrt(expected[k] * (1 - expected[k]) / photons));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_bodies_hold_their_light_as_large_ones_do),
        cmocka_unit_test(a_small_clear_sphere_shares_light_as_fresnel_has_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
