/* Bodies against what is known without them: shadows, Snell and Fresnel of single packets, a sphere in
 * another one, meshes in place of spheres. SPDX-License-Identifier: MIT */
#include "flight.h"

#include "body_files.h"

#include <math.h>

static void open_text(const char *text, const char *engine, enum cml_surface_kind kind, double tolerance,
                      struct flight *flight)
{
    const struct flight_options with = {.engine = engine, .kind = kind, .tolerance = tolerance};
    flight_open(text, &with, flight);
}

/* Scenes of one clear layer of 1 cm, all indices n, with bodies. */
static void layer_text(char *text, size_t size, const char *beam, double n, const char *bodies)
{
    snprintf(text, size, "1.0\n1\nbodies A\n1000\n0.01 0.01\n10 10 1\n%s\n1\n%g\n%g 0 0 0 1\n%s\n%g\n", beam,
             n, n, bodies, n);
}

/* Parallel light on a black sphere: what falls into its shadow ends there, all else passes. Packet by packet,
 * but those within rounding of the rim. */
static void a_black_sphere_has_a_round_shadow(void **state)
{
    (void)state;
    static const char *const engines[] = {"reference", "cpu"};
    char text[1024];
    layer_text(text, sizeof text, "beam disk 0.5", 1.4, "i sphere 0 0 0.5 0.3 1.4 1e9 0 0");
    for (size_t e = 0; e < 2; e++) {
        struct flight flight;
        int hit = 0, photons = 20000;
        open_text(text, engines[e], CML_SURFACE_AUTO, 0, &flight);
        for (int i = 0; i < photons; i++) {
            const struct cml_fate_record record = fly(&flight, (uint64_t)i);
            hit += record.fate == CML_FATE_ABSORBED;
            if (record.fate != CML_FATE_TRANSMITTED) continue;
            assert_true(hypot(record.exit[0], record.exit[1]) > 0.3 * (1 - 1e-6));
        }
        const double share = (double)hit / photons, expected = 0.36;
        assert_true(fabs(share - expected) < 4 * sqrt(expected * (1 - expected) / photons));
        flight_close(&flight);
    }
}

/* Where a ray that meets a sphere of radius r about the axis at the distance b from it leaves, having been
 * refracted twice: its angle to the axis. */
static double twice_refracted(double b, double r, double n1, double n2)
{
    return 2 * (asin(b / r) - asin(b * n1 / (r * n2)));
}

/* Air in glass and glass in air: packets that go through without a reflection inside come out as Snell has
 * it, to 1e-6; how many do, Fresnel's equations say. */
static void a_sphere_refracts_as_snell_and_fresnel_have_it(void **state)
{
    (void)state;
    static const double indices[][2] = {{1, 1.5}, {1.5, 1}, {1.33, 1.4}};
    const double r = 0.3;
    for (size_t i = 0; i < sizeof indices / sizeof *indices; i++)
        for (double b = 0.02; b < 0.19; b += 0.055) {
            const double n1 = indices[i][0], n2 = indices[i][1];
            char text[1024], beam[64], body[128];
            struct flight flight;
            snprintf(beam, sizeof beam, "beam pencil at=%.3f,0", b);
            snprintf(body, sizeof body, "i sphere 0 0 0.5 %g %g 0 0 0", r, n2);
            layer_text(text, sizeof text, beam, n1, body);
            open_text(text, "reference", CML_SURFACE_AUTO, 0, &flight);
            const double turn = twice_refracted(b, r, n1, n2), in = asin(b / r), t = asin(b * n1 / (r * n2));
            const double s = sin(in - t) / sin(in + t), p = tan(in - t) / tan(in + t),
                         R = 0.5 * (s * s + p * p);
            int through = 0, photons = 4000;
            for (int k = 0; k < photons; k++) {
                const struct cml_fate_record record = fly(&flight, (uint64_t)k);
                if (record.boundary_events != 3 || record.fate != CML_FATE_TRANSMITTED) continue;
                if (!(fabs(atan2(-record.direction[0], record.direction[2]) - turn) < 1e-6)) continue;
                through++;
            }
            const double expected = (1 - R) * (1 - R);
            assert_true(fabs((double)through / photons - expected) <
                        4 * sqrt(expected * (1 - expected) / photons) + 1e-3);
            flight_close(&flight);
        }
}

/* One medium in two nested spheres, whose surfaces lie 1e-6 cm apart, is one sphere. */
static void nested_spheres_are_one(void **state)
{
    (void)state;
    char text[1024];
    struct flight one, nested;
#define HOST "1.0\n1\nbodies A\n1000\n0.01 0.01\n10 10 1\n1\n1\n1.37 0.5 50 0.9 0.5\n"
#define INNER " 1.5 2 20 0.8\n"
    open_text(HOST "i sphere 0 0 0.25 0.1" INNER "1\n", "reference", CML_SURFACE_AUTO, 0, &one);
    snprintf(text, sizeof text, "%s",
             HOST "i sphere 0 0 0.25 0.099999" INNER "i sphere 0 0 0.25 0.1" INNER
                  "i sphere 0 0.01 0.25 0.05" INNER "1\n");
    open_text(text, "reference", CML_SURFACE_AUTO, 0, &nested);
    assert_int_equal(nested.list.scenes[0].bodies[0].host, 4);
    assert_int_equal(nested.list.scenes[0].bodies[2].host, 3);
    assert_int_equal((int)count_different(&one, &nested, 3000), 0);
    flight_close(&one);
    flight_close(&nested);
}

/* How many of the packets end in another way than with the sphere and the cylinder themselves. */
static double share_different(const char *text, double tolerance, uint64_t photons)
{
    struct flight exact, mesh;
    open_text(text, "cpu", CML_SURFACE_AUTO, 0, &exact);
    open_text(text, "cpu", CML_SURFACE_MESH, tolerance, &mesh);
    assert_int_equal(mesh.surfaces.bodies.item[0].kind, CML_SURFACE_MESH);
    const double share = (double)count_different(&exact, &mesh, photons) / (double)photons;
    flight_close(&exact);
    flight_close(&mesh);
    return share;
}

/* Of matched indices a packet ends otherwise when it scatters between body and mesh: as often as the volume
 * between them is large, which falls with the tolerance. */
static void meshes_come_to_be_spheres_and_cylinders(void **state)
{
    (void)state;
    const char *text =
        "1.0\n1\nbodies A\n1000\n0.01 0.01\n10 10 1\nbeam disk 0.1\n1\n1.37\n1.37 0.1 20 0.5 0.5\n"
        "i sphere 0 0 0.2 0.15 1.37 20 1 0\ni cylinder -0.3 0 0.42 0.3 0.05 0.42 0.05 1.37 5 5 0\n"
        "1.37\n";
    const double coarse = share_different(text, 1e-2, 20000), fine = share_different(text, 1e-3, 20000);
    assert_true(coarse > 0.001);
    assert_true(fine < 0.25 * coarse);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_black_sphere_has_a_round_shadow),
        cmocka_unit_test(a_sphere_refracts_as_snell_and_fresnel_have_it),
        cmocka_unit_test(nested_spheres_are_one),
        cmocka_unit_test(meshes_come_to_be_spheres_and_cylinders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
