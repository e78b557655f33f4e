/* Scenes whose answer is known on paper: ray optics without scattering, absorption without scattering,
 * symmetry.
 * SPDX-License-Identifier: MIT */
#include "flight.h"

#include <math.h>

static const double degree = 0.017453292519943295;

/* Returns the first packet that passes straight through: the fate, after `events` boundary events. Other
 * packets are reflected at an interface, which is right, but not the path that the formula describes. */
static struct cml_fate_record first_through(const struct flight *flight, int fate, uint32_t events)
{
    for (uint64_t i = 0; i < 100; i++) {
        const struct cml_fate_record record = fly(flight, i);
        if (record.fate == fate && record.boundary_events == events) return record;
    }
    fail_msg("none of 100 packets takes the direct path");
    return fly(flight, 0);
}

static void expect_close(double value, double expected, const char *what)
{
    if (!(fabs(value - expected) <= 1e-6 * fabs(expected) + 1e-9))
        fail_msg("%s: %.12g, expected %.12g", what, value, expected);
}

/* Checks a plane entry and an exit at a cone of base angle a: the deviation is asin(n sin a) - a, away from
 * the axis. */
static void expect_axicon(const char *engine, enum cml_surface_kind kind, double n, double deviation)
{
    char text[512];
    struct flight flight;
    const double a = 10 * degree;
    const struct flight_options with = {.engine = engine, .kind = kind, .normals = CML_NORMALS_ANALYTIC};
    snprintf(text, sizeof text,
             "1.0\n1\naxicon A\n1\nbeam pencil at=0.12,-0.09\n0.01 0.01\n1 1 1\n1\n1\n%.17g 0 0 0 0.5\n"
             "b 2 %.17g 0.5 0 0\n1\n",
             n, -0.5 * tan(a));
    flight_open(text, &with, &flight);
    const struct cml_fate_record end = first_through(&flight, CML_FATE_TRANSMITTED, 1);
    expect_close(hypot(end.direction[0], end.direction[1]), sin(deviation), "axicon: sine of the deviation");
    expect_close(end.direction[0] / -sin(deviation), 0.8, "axicon: azimuth, x");
    expect_close(end.direction[1] / -sin(deviation), -0.6, "axicon: azimuth, y");
    expect_close(end.exit[0], 0.12, "axicon: exit x");
    expect_close(end.exit[1], -0.09, "axicon: exit y");
    flight_close(&flight);
}

static void axicon_deviates_by_its_formula(void **state)
{
    (void)state;
    static const char *const engines[] = {"reference", "cpu"};
    for (int e = 0; e < 2; e++)
        for (int kind = CML_SURFACE_CONE; kind <= CML_SURFACE_MESH; kind++) {
            expect_axicon(engines[e], (enum cml_surface_kind)kind, 1.33, 0.058523175);
            expect_axicon(engines[e], (enum cml_surface_kind)kind, 1.5, 0.088978397);
        }
}

/* Checks refraction at the ramp of wedge.obj, which rises by 1/7 along x from x = -0.4, and then at the
 * plane below. */
static void expect_wedge(const char *engine)
{
    char text[512];
    struct flight flight;
    const double n = 1.5, x = 0.05, tilt = atan(1.0 / 7), inside = tilt - asin(sin(tilt) / n);
    const struct flight_options with = {.engine = engine, .kind = CML_SURFACE_AUTO};
    snprintf(
        text, sizeof text,
        "1.0\n1\nwedge A\n1\nbeam pencil at=%.17g,0.02\n0.01 0.01\n1 1 1\n1\n1\nm \"%s/meshes/wedge.obj\"\n"
        "%.17g 0 0 0 0.5\n1\n",
        x, CML_SOURCE_DIR, n);
    flight_open(text, &with, &flight);
    const struct cml_fate_record end = first_through(&flight, CML_FATE_TRANSMITTED, 2);
    expect_close(end.exit[0], x + tan(inside) * (0.5 + (x + 0.4) / 7), "wedge: exit x");
    expect_close(end.exit[1], 0.02, "wedge: exit y");
    expect_close(end.direction[0], n * sin(inside), "wedge: sine of the exit angle");
    expect_close(end.direction[1], 0, "wedge: exit direction y");
    flight_close(&flight);
}

static void wedge_refracts_by_snell(void **state)
{
    (void)state;
    expect_wedge("reference");
    expect_wedge("cpu");
}

/* Checks a right-angled roof prism: total reflection at both faces sends the ray back at -x, for every x. */
static void expect_prism(const char *engine)
{
    char text[512];
    struct flight flight;
    const struct flight_options with = {.engine = engine, .kind = CML_SURFACE_AUTO};
    snprintf(text, sizeof text,
             "1.0\n1\nprism A\n1\nbeam pencil at=0.11,0.03\n0.01 0.01\n1 1 1\n1\n1\n1.5 0 0 0 0.5\n"
             "m \"%s/meshes/prism.obj\" up=-z\n1\n",
             CML_SOURCE_DIR);
    flight_open(text, &with, &flight);
    const struct cml_fate_record end = first_through(&flight, CML_FATE_REFLECTED, 3);
    expect_close(end.exit[0], -0.11, "prism: exit x");
    expect_close(end.exit[1], 0.03, "prism: exit y");
    expect_close(end.direction[2], -1, "prism: exit direction");
    flight_close(&flight);
}

static void prism_returns_the_ray_by_total_reflection(void **state)
{
    (void)state;
    expect_prism("reference");
    expect_prism("cpu");
}

/* Checks a disk beam on a hill of slope m, matched below. T is Fresnel's transmission times the mean of
 * exp(-mua path) over the disk, with path = (d + h(r)) / cos(delta); delta is the bend at the hill's flank.
 */
static void expect_absorbing_hill(const char *engine, enum cml_surface_kind kind)
{
    const double H = 0.1, R = 0.5, d = 0.4, mua = 3, n = 1.4, photons = 100000;
    const double i = atan(H / R), t = asin(sin(i) / n), k = mua / cos(i - t), s = k * H / R;
    const double rs = sin(i - t) / sin(i + t), rp = tan(i - t) / tan(i + t);
    /* integral of exp(-k (d + H (1 - r/R))) 2 r dr / R^2 over 0..R, with s = k H / R */
    const double integral = 2 / (R * R) * exp(-k * (d + H)) * ((exp(s * R) * (s * R - 1) + 1) / (s * s));
    const double expected = (1 - (rs * rs + rp * rp) / 2) * integral;
    char text[512];
    struct flight flight;
    const struct flight_options with = {.engine = engine, .kind = kind, .normals = CML_NORMALS_ANALYTIC};
    snprintf(text, sizeof text,
             "1.0\n1\nhill A\n1\nbeam disk %g\n0.01 0.01\n1 1 1\n1\n1\nb 2 %g %g 0 0\n%g %g 0 0 %g\n%g\n", R,
             H, R, n, mua, d, n);
    flight_open(text, &with, &flight);
    double transmitted = 0;
    for (uint64_t photon = 0; photon < (uint64_t)photons; photon++)
        transmitted += fly(&flight, photon).fate == CML_FATE_TRANSMITTED;
    const double p = transmitted / photons, error = sqrt(expected * (1 - expected) / photons);
    print_message("absorbing hill, %s, %s: T = %.5f +- %.5f, expected %.5f\n", engine,
                  cml_surface_kind_name(kind), p, error, expected);
    assert_true(fabs(p - expected) < 4.5 * error);
    flight_close(&flight);
}

static void absorbing_hill_transmits_the_integral(void **state)
{
    (void)state;
    expect_absorbing_hill("reference", CML_SURFACE_CONE);
    expect_absorbing_hill("reference", CML_SURFACE_MESH);
    expect_absorbing_hill("cpu", CML_SURFACE_CONE);
    expect_absorbing_hill("cpu", CML_SURFACE_MESH);
}

/* Checks that a pencil beam on the tip of a cone prefers no azimuth: moments cos and sin of k phi of the
 * exit points, k = 1..8 (the mesh's innermost ring has 8 segments). The level is 1e-4 over all moments. */
static void expect_symmetric(const char *engine, enum cml_surface_kind kind)
{
    enum { ORDERS = 8 };
    const struct flight_options with = {.engine = engine, .kind = kind, .normals = CML_NORMALS_ANALYTIC};
    struct flight flight;
    double moment[2 * ORDERS] = {0}, exits = 0;
    flight_open(
        "1.0\n1\ntip A\n1\n0.01 0.01\n1 1 1\n1\n1\nb 3 0.2 0.15 0.05 0.2 0 0\n1.4 0.1 10 0.5 0.3\n1\n", &with,
        &flight);
    for (uint64_t i = 0; i < 60000; i++) {
        const struct cml_fate_record end = fly(&flight, i);
        if (end.fate != CML_FATE_REFLECTED && end.fate != CML_FATE_TRANSMITTED) continue;
        if (hypot(end.exit[0], end.exit[1]) < 1e-6) continue; /* an unscattered packet is still on the axis */
        const double phi = atan2(end.exit[1], end.exit[0]);
        for (int k = 0; k < ORDERS; k++) {
            moment[2 * k] += cos((k + 1) * phi);
            moment[2 * k + 1] += sin((k + 1) * phi);
        }
        exits += 1;
    }
    assert_true(exits > 30000);
    for (int k = 0; k < 2 * ORDERS; k++)
        if (!(fabs(moment[k]) / sqrt(exits / 2) < 4.7))
            fail_msg("%s, %s: azimuthal moment %d is %.2f standard errors", engine,
                     cml_surface_kind_name(kind), k / 2 + 1, moment[k] / sqrt(exits / 2));
    flight_close(&flight);
}

static void pencil_beam_on_a_tip_is_symmetric(void **state)
{
    (void)state;
    expect_symmetric("cpu", CML_SURFACE_CONE);
    expect_symmetric("cpu", CML_SURFACE_MESH);
    expect_symmetric("reference", CML_SURFACE_MESH);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axicon_deviates_by_its_formula),
        cmocka_unit_test(wedge_refracts_by_snell),
        cmocka_unit_test(prism_returns_the_ray_by_total_reflection),
        cmocka_unit_test(absorbing_hill_transmits_the_integral),
        cmocka_unit_test(pencil_beam_on_a_tip_is_symmetric),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
