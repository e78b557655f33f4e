/* Tests changes that must change no result: scaling by a power of two, and moving scene and beam together.
 * SPDX-License-Identifier: MIT */
#include "flight.h"

/* Writes a scene: ridges.obj over a noisy field over a plane, all lengths times `scale`, moved by `shift` cm
 * along x. */
static void stack_scene(double scale, double shift, bool field, char *text, size_t size)
{
    char interior[512] = "";
    if (field)
        snprintf(interior, sizeof interior, "b 4 %.17g %.17g %.17g %.17g %.17g %.17g 0 0\n", 0.01 * scale,
                 0.0625 * scale, -0.02 * scale, 0.125 * scale, 0.03 * scale, 0.25 * scale);
    snprintf(text, size,
             "1.0\n1\nstack A\n1\nbeam pencil at=%.17g,%.17g angle=25\n0.01 0.01\n1 1 1\n2\n1\n"
             "m \"%s/meshes/ridges.obj\" scale=%.17g shift=%.17g,0,0\n1.4 %.17g %.17g 0.8 %.17g\n%s"
             "1.5 %.17g %.17g 0.3 %.17g\n1\n",
             shift + 0.0625 * scale, 0.03125 * scale, CML_SOURCE_DIR, scale, shift, 0.5 / scale, 16 / scale,
             0.25 * scale, interior, 1 / scale, 8 / scale, 0.5 * scale);
}

static void expect_same(const char *first, const char *second, const char *engine, uint64_t photons,
                        uint64_t allowed, const char *what)
{
    const struct flight_options with = {.engine = engine, .kind = CML_SURFACE_AUTO};
    struct flight a, b;
    flight_open(first, &with, &a);
    flight_open(second, &with, &b);
    const uint64_t different = count_different(&a, &b, photons);
    if (different > allowed)
        fail_msg("%s, %s: %llu of %llu packets changed", engine, what, (unsigned long long)different,
                 (unsigned long long)photons);
    flight_close(&a);
    flight_close(&b);
}

static void scaling_by_a_power_of_two_changes_no_packet(void **state)
{
    (void)state;
    static const double scales[] = {1024, 1.0 / 65536};
    char plain[1024], scaled[1024];
    stack_scene(1, 0, true, plain, sizeof plain);
    for (int i = 0; i < 2; i++) {
        stack_scene(scales[i], 0, true, scaled, sizeof scaled);
        expect_same(plain, scaled, "cpu", 5000, 0, "scaled");
        expect_same(plain, scaled, "reference", 2000, 0, "scaled");
    }
}

/* Moves a mesh and the beam. A radial field cannot be moved. Only the last bits of the mesh's vertices
 * change. */
static void moving_scene_and_beam_changes_no_packet(void **state)
{
    (void)state;
    static const double shifts[] = {1000, -123456.7};
    char plain[1024], moved[1024];
    stack_scene(1, 0, false, plain, sizeof plain);
    for (int i = 0; i < 2; i++) {
        stack_scene(1, shifts[i], false, moved, sizeof moved);
        expect_same(plain, moved, "cpu", 20000, 2, "moved");
        expect_same(plain, moved, "reference", 5000, 0, "moved");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scaling_by_a_power_of_two_changes_no_packet),
        cmocka_unit_test(moving_scene_and_beam_changes_no_packet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
