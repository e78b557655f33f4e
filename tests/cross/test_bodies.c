/* Bodies against answers known without them: shadows, Snell and Fresnel for single packets, a sphere in
 * another sphere, meshes in place of spheres.
 * SPDX-License-Identifier: MIT */
#include "flight.h"

#include "body_files.h"

#include "engine/world_parts.h"
#include "surface_hit.h"

#include <math.h>

static void open_text(const char *text, const char *engine, enum cml_surface_kind kind, double tolerance,
                      struct flight *flight)
{
    const struct flight_options with = {.engine = engine, .kind = kind, .tolerance = tolerance};
    flight_open(text, &with, flight);
}

/* Writes a scene of one clear layer of 1 cm with bodies. All indices are n. */
static void layer_text(char *text, size_t size, const char *beam, double n, const char *bodies)
{
    snprintf(text, size, "1.0\n1\nbodies A\n1000\n0.01 0.01\n10 10 1\n%s\n1\n%g\n%g 0 0 0 1\n%s\n%g\n", beam,
             n, n, bodies, n);
}

/* Parallel light on a black sphere: light within its shadow is absorbed, all other light passes. Each packet
 * is tested, except those within rounding of the rim. */
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

/* Returns the angle to the axis of a ray that was refracted twice by a sphere of radius r about the axis. b:
 * distance of the ray from the axis before the sphere. */
static double twice_refracted(double b, double r, double n1, double n2)
{
    return 2 * (asin(b / r) - asin(b * n1 / (r * n2)));
}

/* Air in glass and glass in air: packets without an inner reflection leave by Snell's law, to 1e-6.
 * Fresnel's equations give their number. */
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

/* Two nested spheres of one medium, with surfaces 1e-6 cm apart, act as one sphere. */
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

/* Returns the share of packets that end differently with meshes than with the sphere and the cylinder
 * themselves. */
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

/* With matched indices, a packet ends differently if it interacts between body and mesh. The share is
 * proportional to the volume between both, which falls with the tolerance. */
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

/* The context that checks a trace. */
struct watch {
    const struct cml_scene *scene;
    double err; /* distance that rounding may put a packet beyond a surface [cm] */
    uint64_t events, wrong;
};

/* Returns +1 if a place is more than err inside a body, -1 if it is more than err outside, else 0. A mesh
 * here stands for a sphere of radius 0.1 cm. */
static int side_of(const struct cml_scene_body *body, const double p[3], double err)
{
    struct cml_scene_body round = *body;
    if (body->form == CML_BODY_MESH) {
        round.form = CML_BODY_SPHERE;
        round.radius = 0.1;
        for (int k = 0; k < 3; k++) round.centre[k] = 0.5 * (body->mesh.lower[k] + body->mesh.upper[k]);
        err = 2e-3;
    }
    const struct cml_convex convex = cml_body_convex(&round);
    const double distance = cml_convex_distance(&convex, p);
    return distance < -err ? 1 : (distance > err ? -1 : 0);
}

/* Checks that an interaction lies inside the body that is the packet's medium, and outside of all bodies
 * within that body. */
static void watch_event(void *context, const struct cml_trace_event *event)
{
    struct watch *watch = context;
    const struct cml_scene *scene = watch->scene;
    if (strcmp(event->what, "interact") != 0) return;
    const int own = event->medium - scene->num_layers - 2;
    watch->events++;
    if (own >= 0 && side_of(&scene->bodies[own], event->position, watch->err) < 0) watch->wrong++;
    for (int k = 0; k < scene->num_bodies; k++)
        if (scene->bodies[k].host == event->medium &&
            side_of(&scene->bodies[k], event->position, watch->err) > 0)
            watch->wrong++;
}

static void expect_right_sides(const char *text, const char *engine, uint64_t photons, double err_position)
{
    struct flight flight;
    open_text(text, engine, CML_SURFACE_AUTO, 0, &flight);
    struct watch watch = {&flight.list.scenes[0], err_position, 0, 0};
    for (uint64_t i = 0; i < photons; i++) {
        struct cml_error err;
        struct cml_fate_record record;
        require_ok(flight.engine->trace(flight.self, i, watch_event, &watch, &record, &err), &err);
        assert_int_not_equal(record.fate, CML_FATE_LOST);
    }
    assert_true(watch.events > photons);
    if (watch.wrong)
        fail_msg("%s: %d of %d events on the wrong side", engine, (int)watch.wrong, (int)watch.events);
    flight_close(&flight);
}

/* Beams along the axis of a sphere and of a cylinder, at their tangents, on the rim of an end and along the
 * side; shells of 1e-6 cm; a mesh struck at a corner, along an edge, and from inside. */
static void packets_are_where_their_medium_is(void **state)
{
    (void)state;
    static const char *const beams[] = {"beam pencil", "beam pencil at=0.1,0", "beam pencil at=0.05,0",
                                        "beam pencil at=0.3,0.05 angle=60 azimuth=180", "beam disk 0.2"};
    static const char *const bodies[] = {
        "i sphere 0 0 0.2 0.1 1.5 1 50 0.5\ni sphere 0 0 0.2 0.099999 1.33 1 50 0.9\n",
        "i cylinder 0 0 0.05 0 0 0.25 0.05 1.2 1 50 0.5\ni cylinder 0 0 0.050001 0 0 0.249999 0.049999 1.6 1 "
        "9 0\n",
        "i cylinder -0.2 0 0.2 0.2 0 0.2 0.1 1 0 0 0\ni sphere 0 0 0.2 0.0999 1.5 3 30 0.9\n", NULL};
    char text[2048], mesh[] = "/tmp/cml_sides_XXXXXX.obj", line[256];
    close(mkstemps(mesh, 4));
    write_sphere(mesh, 0, 0, 0.2, 0.1, 16);
    snprintf(line, sizeof line, "i \"%s\" 1.5 1 50 0.5\ni sphere 0 0 0.2 0.05 1 0 0 0\n", mesh);
    for (size_t i = 0; i < sizeof bodies / sizeof *bodies; i++)
        for (size_t k = 0; k < sizeof beams / sizeof *beams; k++) {
            snprintf(text, sizeof text,
                     "1.0\n1\nsides A\n1000\n0.01 0.01\n10 10 1\n%s\n1\n1\n1.4 0.5 30 0.8 0.5\n%s1\n",
                     beams[k], bodies[i] ? bodies[i] : line);
            expect_right_sides(text, "reference", 300, 1e-12);
            expect_right_sides(text, "cpu", 1000, 5e-7);
        }
    remove(mesh);
}

/* Tests 1e4 beads on a grid, in a volume that light crosses in all directions. */
static void ten_thousand_beads_lose_no_packet(void **state)
{
    (void)state;
    char *text = malloc(1000000), *at = text;
    at += sprintf(at,
                  "1.0\n1\nbeads A\n1000\n0.01 0.01\n10 10 1\nbeam disk 0.2\n1\n1.5\n1.5 0.5 100 0.8 0.1\n");
    for (int i = 0; i < 10000; i++)
        at +=
            sprintf(at, "i sphere %g %g %g 0.0045 %s\n", 0.01 * (i % 50) - 0.245,
                    0.01 * (i / 50 % 50) - 0.245, 0.02 + 0.02 * (i / 2500), i % 2 ? "1 0 0 0" : "1.9 2 50 0");
    sprintf(at, "1.5\n");
    expect_right_sides(text, "cpu", 100, 2e-7);
    free(text);
}

/* A generator of random numbers. */
struct dice {
    uint64_t state;
};

static double throw(struct dice * dice)
{
    dice->state = dice->state * 6364136223846793005u + 1442695040888963407u;
    return (double)(dice->state >> 11) * 0x1p-53;
}

static struct cml_vec random_direction(struct dice *dice)
{
    double v[3], square;
    do {
        for (int k = 0; k < 3; k++) v[k] = 2 * throw(dice) - 1;
        square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    } while (!(square < 1) || !(square > 0.01));
    const double k = 1 / sqrt(square);
    return cml_vec_of(k * v[0], k * v[1], k * v[2]);
}

/* Returns the medium of a place: layer 1 or the innermost body, or -1 within err of a surface. */
static int medium_at(const struct cml_scene *scene, const double p[3], double err)
{
    int medium = 1;
    for (int k = 0; k < scene->num_bodies; k++) {
        const struct cml_convex convex = cml_body_convex(&scene->bodies[k]);
        const double distance = cml_convex_distance(&convex, p);
        if (fabs(distance) < err) return -1;
        if (distance < 0) medium = cml_body_medium(scene, k);
    }
    return medium;
}

/* Returns places inside, around and far from the bodies. Every other place is close to a surface. */
static void random_place(struct dice *dice, const struct cml_scene *scene, int i, double p[3])
{
    for (int k = 0; k < 3; k++) p[k] = (throw(dice) - 0.5) * (i % 3 ? 0.7 : 6) + (k == 2 ? 0.25 : 0);
    if (i % 2) return;
    const struct cml_scene_body *body = &scene->bodies[i / 2 % scene->num_bodies];
    const struct cml_vec u = random_direction(dice);
    const double r = body->radius + 0.004 * (throw(dice) - 0.5), along = throw(dice);
    const double out[3] = {u.x, u.y, u.z};
    for (int k = 0; k < 3; k++) {
        const double end = body->form == CML_BODY_CYLINDER ? body->end[k] : body->centre[k];
        p[k] = body->centre[k] + along * (end - body->centre[k]) + r * out[k];
    }
}

/* True if a packet in this medium meets a body within the path. Bounding balls and free regions are not
 * used. */
static int meets_body(const struct cml_world *world, int medium, struct cml_vec p, struct cml_vec u,
                      real path)
{
    struct cml_hit hit;
    struct cml_packet packet = {.p = p, .u = u, .medium = medium, .on_boundary = -1, .on_primitive = -1};
    return cml_nearest_body(world, &packet, path, 0, &hit);
}

/* Tries a random path from the end of one that meets no body. Returns 0 if the path leaves the region found
 * there, 1 if it stays and meets no body, 2 if it stays and meets one. */
static int leaves_region(struct dice *dice, const struct cml_world *world, int medium, struct cml_vec from,
                         const struct cml_body_region *region)
{
    const struct cml_vec u = random_direction(dice);
    const real path = (real)(0.05 * throw(dice));
    const struct cml_vec off = cml_along(from, -1, region->middle), to = cml_along(off, path, u);
    const int within = cml_dot(off, off) < region->square && cml_dot(to, to) < region->square &&
                       cml_dot(region->normal, off) > region->least &&
                       cml_dot(region->normal, to) > region->least;
    return within ? 1 + meets_body(world, medium, from, u, path) : 0;
}

/* Checks that a path that is reported to meet no body meets none, and that no path in its region does. err:
 * possible distance of a surface from the body's [cm]. */
static void expect_free_paths(const char *text, enum cml_surface_kind kind, double err)
{
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct cml_owned_world world;
    struct cml_error error;
    struct dice dice = {1};
    const struct cml_surface_options surface = {.force = kind,
                                                .tessellation = {1e-3, CML_NORMALS_ANALYTIC, false}};
    const struct cml_engine_options options = {.seed = 1};
    read_scenes(text, &list);
    require_ok(cml_surfaces_create(list.scenes, &surface, &surfaces, &error), &error);
    require_ok(cml_owned_world_create(list.scenes, &surfaces, &options, &world, &error), &error);
    uint64_t paths = 0, met = 0, asked = 0, wrong = 0, in_region = 0, wrong_region = 0;
    for (int i = 0; i < 300000; i++) {
        double p[3];
        struct cml_body_region region;
        random_place(&dice, list.scenes, i, p);
        const int medium = medium_at(list.scenes, p, err);
        const struct cml_vec from = cml_vec_of(p[0], p[1], p[2]), u = random_direction(&dice);
        const real path = (real)pow(10, -3.5 + 3 * throw(&dice));
        if (medium < 0) continue;
        const int may = cml_may_hit_body(&world.world, medium, from, u, path, &region) != CML_NO_BODIES;
        const int meets = meets_body(&world.world, medium, from, u, path);
        paths++;
        met += (uint64_t)meets;
        asked += (uint64_t)may;
        wrong += (uint64_t)(meets && !may);
        if (may) continue;
        const int second = leaves_region(&dice, &world.world, medium, cml_along(from, path, u), &region);
        in_region += second > 0;
        wrong_region += second > 1;
    }
    print_message(
        "%llu paths: %llu meet a body, %llu might, %llu wrongly not; %llu in regions, %llu wrongly\n",
        (unsigned long long)paths, (unsigned long long)met, (unsigned long long)asked,
        (unsigned long long)wrong, (unsigned long long)in_region, (unsigned long long)wrong_region);
    assert_int_equal(wrong + wrong_region, 0);
    assert_true(met > paths / 50 && asked < 3 * met && in_region > paths / 4);
    cml_owned_world_free(&world);
    cml_surfaces_free(&surfaces);
    cml_scene_list_clear(&list);
}

static void paths_said_to_be_free_are(void **state)
{
    (void)state;
    const char *text = "1.0\n1\nsides A\n1000\n0.01 0.01\n10 10 1\n1\n1\n1.4 0.5 90 0.8 0.5\n"
                       "i sphere 0.1 0.02 0.2 0.1 1.5 1 50 0.5\ni sphere 0.1 0 0.2 0.03 1 0 0 0\n"
                       "i cylinder -0.3 0.1 0.4 0.3 0.2 0.42 0.03 1.2 1 50 0.5\n1\n";
    expect_free_paths(text, CML_SURFACE_AUTO, 1e-6);
    expect_free_paths(text, CML_SURFACE_MESH, 3e-4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_black_sphere_has_a_round_shadow),
        cmocka_unit_test(a_sphere_refracts_as_snell_and_fresnel_have_it),
        cmocka_unit_test(nested_spheres_are_one),
        cmocka_unit_test(packets_are_where_their_medium_is),
        cmocka_unit_test(ten_thousand_beads_lose_no_packet),
        cmocka_unit_test(paths_said_to_be_free_are),
        cmocka_unit_test(meshes_come_to_be_spheres_and_cylinders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
