/* The null test: a boundary between identical media changes no result, for any shape and representation. An
 * energy balance cannot notice a wrong geometry, but this test can: every packet must keep its fate and its
 * number of interactions.
 * SPDX-License-Identifier: MIT */
#include "flight.h"

#include "body_files.h"

#define MEDIUM "1.37 0.5 20 0.8 "

static const char *const whole = "1.0\n1\nwhole A\n1000\n0.01 0.01\n10 10 1\n1\n1\n" MEDIUM "0.8\n1\n";

/* Interior boundaries at z = 0.4 cm. */
static const char *const shapes[] = {
    "b 5 0.1 0.1 0.08 0.1 0.05 0.2 0.02 0.1 0 0",                                                 /* hill */
    "b 9 0.02 0.05 -0.03 0.05 0.04 0.05 -0.05 0.05 0.01 0.05 0.06 0.05 -0.02 0.05 0.03 0.05 0 0", /* noise */
    "b 9 0.3 0.01 -0.3 0.01 0.3 0.02 -0.3 0.01 0.25 0.01 -0.2 0.05 0.3 0.005 -0.35 0.1 0 0", /* steep spikes
                                                                                              */
};
static const char *const meshes[] = {"wedge.obj\" scale=0.5",           "ridges.obj\" scale=0.5",
                                     "spikes.obj\" scale=0.5",          "overhang.obj\" scale=0.5",
                                     "pyramid.obj\" scale=0.5",         "grooves.asc\" units=mm tile scale=3",
                                     "skin.gsf\" tile=mirror scale=0.5"};

static void split_scene(const char *boundary, char *text, size_t size)
{
    snprintf(text, size,
             "1.0\n1\nsplit A\n1000\n0.01 0.01\n10 10 1\n2\n1\n" MEDIUM "0.4\n%s\n" MEDIUM "0.4\n1\n",
             boundary);
}

static void expect_no_change(const char *boundary, const char *engine, enum cml_surface_kind kind,
                             uint64_t photons, uint64_t allowed)
{
    char text[2048];
    struct flight a, b;
    const struct flight_options with = {.engine = engine, .kind = kind, .normals = CML_NORMALS_ANALYTIC};
    split_scene(boundary, text, sizeof text);
    flight_open(whole, &with, &a);
    flight_open(text, &with, &b);
    const uint64_t different = count_different(&a, &b, photons);
    if (different > allowed)
        fail_msg("%s, %s: %llu of %llu packets changed (at most %llu may): %s", engine,
                 cml_surface_kind_name(kind), (unsigned long long)different, (unsigned long long)photons,
                 (unsigned long long)allowed, boundary);
    flight_close(&a);
    flight_close(&b);
}

static void expect_no_change_any_shape(const char *engine, uint64_t photons, uint64_t allowed)
{
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        expect_no_change(shapes[i], engine, CML_SURFACE_CONE, photons, allowed);
        expect_no_change(shapes[i], engine, CML_SURFACE_MESH, photons, allowed);
    }
    for (size_t i = 0; i < sizeof meshes / sizeof *meshes; i++) {
        char line[512];
        snprintf(line, sizeof line, "m \"%s/meshes/%s", CML_SOURCE_DIR, meshes[i]);
        expect_no_change(line, engine, CML_SURFACE_AUTO, photons, allowed);
    }
}

static void reference_changes_no_packet(void **state)
{
    (void)state;
    expect_no_change_any_shape("reference", 4000, 0);
}

/* 99.99 % of packets are unchanged. Rounding to single precision sometimes moves a packet across a boundary
 * or bin. */
static void cpu_changes_at_most_one_packet_in_ten_thousand(void **state)
{
    (void)state;
    expect_no_change_any_shape("cpu", 20000, 2);
}

/* Checks that bodies of the layer's medium change no packet: nested, side by side, in the way of the beam, a
 * mesh with a sphere inside. */
static void expect_no_change_with_bodies(const char *engine, uint64_t photons, uint64_t allowed)
{
    char text[2048], mesh[] = "/tmp/cml_null_XXXXXX.obj";
    struct flight a, b;
    const struct flight_options with = {.engine = engine, .normals = CML_NORMALS_FACET};
    close(mkstemps(mesh, 4));
    write_sphere(mesh, 0.35, 0, 0.35, 0.2, 8);
    snprintf(text, sizeof text,
             "1.0\n1\nbodies A\n1000\n0.01 0.01\n10 10 1\n1\n1\n" MEDIUM "0.8\n"
             "i sphere 0.01 0 0.3 0.12 " MEDIUM "\ni sphere 0.02 0.01 0.32 0.08 " MEDIUM "\n"
             "i cylinder -0.02 -0.3 0.6 0.03 0.4 0.62 0.05 " MEDIUM "\n"
             "i cylinder 0 -0.02 0.01 0 0.02 0.15 0.01 " MEDIUM "\n"
             "i \"%s\" " MEDIUM "\ni sphere 0.35 0 0.35 0.1 " MEDIUM "\n1\n",
             mesh);
    flight_open(whole, &with, &a);
    flight_open(text, &with, &b);
    remove(mesh);
    uint64_t crossings = 0;
    for (uint64_t photon = 0; photon < 100; photon++) crossings += fly(&b, photon).boundary_events;
    assert_true(crossings > 300);
    const uint64_t different = count_different(&a, &b, photons);
    if (different > allowed)
        fail_msg("%s: %llu of %llu packets changed (at most %llu may)", engine, (unsigned long long)different,
                 (unsigned long long)photons, (unsigned long long)allowed);
    flight_close(&a);
    flight_close(&b);
}

static void bodies_change_no_packet(void **state)
{
    (void)state;
    expect_no_change_with_bodies("reference", 4000, 0);
    expect_no_change_with_bodies("cpu", 20000, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reference_changes_no_packet),
        cmocka_unit_test(cpu_changes_at_most_one_packet_in_ten_thousand),
        cmocka_unit_test(bodies_change_no_packet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
