/* Beams aimed at delicate places: exactly at vertices and edges of a mesh, grazing, at the angle of almost
 * no reflection, and into a body from which light never gets out. The answers are known on paper.
 * SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "flight.h"

#include <math.h>

#define DEGREE 0.017453292519943295

static const char *const engines[] = {"reference", "cpu"};

/* ---- through vertices and edges ---- */

#define MOST_VERTICES 4000

/* Reads the vertices of an OBJ file of at most MOST_VERTICES. Returns their number. */
static int read_vertices(const char *path, double vertex[][3])
{
    FILE *file = fopen(path, "r");
    char line[256];
    int n = 0;
    assert_non_null(file);
    while (n < MOST_VERTICES && fgets(line, sizeof line, file))
        n += sscanf(line, "v %lf %lf %lf", &vertex[n][0], &vertex[n][1], &vertex[n][2]) == 3;
    fclose(file);
    return n;
}

/* Reads the vertices of face `wanted`, counted from 0. Returns false if the file has no such face. */
static bool read_face(const char *path, int wanted, int corner[3])
{
    FILE *file = fopen(path, "r");
    char line[256];
    bool found = false;
    assert_non_null(file);
    while (!found && fgets(line, sizeof line, file))
        found = sscanf(line, "f %d %d %d", &corner[0], &corner[1], &corner[2]) == 3 && wanted-- == 0;
    fclose(file);
    for (int i = 0; found && i < 3; i++) corner[i]--;
    return found;
}

struct entry {
    int count;
    double z;
};

static void note_entry(void *context, const struct cml_trace_event *event)
{
    struct entry *entry = context;
    if (event->medium != 2 || strcmp(event->what, "transmit") != 0) return;
    entry->count++;
    entry->z = event->position[2];
}

/* Checks that a beam along z at (x, y) crosses a mesh between clear media of equal index once, at the depth
 * of the mesh there. */
static void expect_depth(const char *engine, const char *mesh, const double place[3])
{
    const struct flight_options with = {.engine = engine, .kind = CML_SURFACE_AUTO};
    const double limit = strcmp(engine, "cpu") == 0 ? 2e-7 : 1e-14;
    char text[1024];
    struct flight flight;
    struct entry entry = {0, 0};
    struct cml_fate_record end;
    struct cml_error err;
    snprintf(text, sizeof text,
             "1.0\n1\nbeam A\n1\nbeam pencil at=%.17g,%.17g\n0.01 0.01\n1 1 1\n2\n1\n1 0 0 0 1\n%s\n1 0 0 0 "
             "0.5\n1\n",
             place[0], place[1], mesh);
    flight_open(text, &with, &flight);
    assert_int_equal(flight.surfaces.item[1].kind, CML_SURFACE_MESH);
    require_ok(flight.engine->trace(flight.self, 0, note_entry, &entry, &end, &err), &err);
    if (end.fate != CML_FATE_TRANSMITTED || entry.count != 1 || !(fabs(entry.z - (1 - place[2])) < limit))
        fail_msg("%s, %s at (%g, %g): %s, %d crossings, the last at %.15g, expected one at %.15g", engine,
                 mesh, place[0], place[1], cml_fate_name(end.fate), entry.count, entry.z, 1 - place[2]);
    flight_close(&flight);
}

/* Checks 60 vertices and points of 60 edges: the middle, and one third of the way, which rounding puts
 * beside the edge. */
static void expect_depths(const char *name, int faces)
{
    static double vertex[MOST_VERTICES][3];
    char path[512], mesh[600];
    struct dice dice = dice_new(41);
    snprintf(path, sizeof path, "%s/meshes/%s", CML_SOURCE_DIR, name);
    snprintf(mesh, sizeof mesh, "m \"%s\"", path);
    const int n = read_vertices(path, vertex);
    for (int i = 0; i < 60; i++) {
        int corner[3];
        const char *const engine = engines[i % 2];
        expect_depth(engine, mesh, vertex[dice_below(&dice, n)]);
        if (!read_face(path, dice_below(&dice, faces), corner)) fail_msg("%s: no such face", path);
        const double *const a = vertex[corner[i % 3]], *const b = vertex[corner[(i + 1) % 3]],
                            part = i < 30 ? 0.5 : 1.0 / 3;
        const double point[3] = {a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]),
                                 a[2] + part * (b[2] - a[2])};
        expect_depth(engine, mesh, point);
    }
}

static void beams_through_vertices_and_edges_meet_the_mesh_there(void **state)
{
    (void)state;
    expect_depths("pyramid.obj", 4);
    expect_depths("spikes.obj", 400);
    expect_depths("ridges.obj", 5000);
}

/* ---- oblique beams ---- */

static void open_slab(const char *engine, double angle, double n_above, double n, double n_below,
                      struct flight *flight)
{
    char text[256];
    const struct flight_options with = {.engine = engine, .kind = CML_SURFACE_AUTO};
    snprintf(text, sizeof text,
             "1.0\n1\nslab A\n1\nbeam pencil angle=%.17g azimuth=30\n0.01 0.01\n1 1 1\n1\n%.17g\n%.17g 0 0 0 "
             "0.5\n%.17g\n",
             angle, n_above, n, n_below);
    flight_open(text, &with, flight);
}

/* Checks a clear slab of index 1.5: Snell's law inside gives the shift, and the ray leaves in its old
 * direction. The cosine is computed from the sine by Pythagoras, so that its rounding error grows towards
 * grazing. */
static void expect_shift(const char *engine, double angle)
{
    struct flight flight;
    struct cml_fate_record end = {0};
    bool through = false;
    const double limit = (strcmp(engine, "cpu") == 0 ? 2e-7 : 1e-14) / cos(angle * DEGREE);
    open_slab(engine, angle, 1, 1.5, 1, &flight);
    for (uint64_t i = 0; i < 100000 && !through; i++) {
        end = fly(&flight, i);
        through = end.fate == CML_FATE_TRANSMITTED && end.boundary_events == 2;
    }
    assert_true(through);
    const double sine = sin(angle * DEGREE), shift = 0.5 * tan(asin(sine / 1.5));
    const double expected[5] = {shift * cos(30 * DEGREE), shift * 0.5, sine * cos(30 * DEGREE), sine * 0.5,
                                cos(angle * DEGREE)};
    const double found[5] = {end.exit[0], end.exit[1], end.direction[0], end.direction[1], end.direction[2]};
    for (int i = 0; i < 5; i++)
        if (!(fabs(found[i] - expected[i]) < limit))
            fail_msg("%s at %g degrees: value %d is %.9g, expected %.9g", engine, angle, i, found[i],
                     expected[i]);
    flight_close(&flight);
}

static void an_oblique_beam_is_shifted_and_not_turned(void **state)
{
    (void)state;
    static const double angles[] = {10, 45, 80, 89, 89.9};
    for (int e = 0; e < 2; e++)
        for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) expect_shift(engines[e], angles[i]);
}

static double fresnel(double angle, double n1, double n2)
{
    const double i = angle * DEGREE, t = asin(n1 * sin(i) / n2);
    const double rs = (n1 * cos(i) - n2 * cos(t)) / (n1 * cos(i) + n2 * cos(t));
    const double rp = (n2 * cos(i) - n1 * cos(t)) / (n2 * cos(i) + n1 * cos(t));
    return (rs * rs + rp * rp) / 2;
}

/* Checks the share of one fate within 4.5 standard errors of a binomial. */
static void expect_share(const struct flight *flight, int fate, double expected, uint64_t photons,
                         const char *what)
{
    double count = 0;
    for (uint64_t i = 0; i < photons; i++) count += (int)fly(flight, i).fate == fate;
    const double share = count / (double)photons, error = sqrt(expected * (1 - expected) / (double)photons);
    if (!(fabs(share - expected) < 4.5 * error))
        fail_msg("%s: %.6f +- %.6f, expected %.6f", what, share, error, expected);
}

/* Tests one surface, matched below, against Fresnel's formula in angles, for reflected shares from almost
 * nothing to almost everything. */
static void the_reflected_share_is_fresnels_however_small_or_grazing(void **state)
{
    (void)state;
    static const struct {
        double angle, n1, n2;
        uint64_t photons;
    } cases[] = {{20, 1.3, 1.34, 400000}, {50, 1.34, 1.3, 400000}, {45, 1, 1.5, 50000},   {80, 1, 1.4, 50000},
                 {89, 1, 1.4, 50000},     {89.9, 1, 1.4, 50000},   {89.99, 1, 1.4, 50000}};
    for (int e = 0; e < 2; e++)
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
            char what[64];
            struct flight flight;
            open_slab(engines[e], cases[i].angle, cases[i].n1, cases[i].n2, cases[i].n2, &flight);
            snprintf(what, sizeof what, "%s, %g degrees, %g to %g", engines[e], cases[i].angle, cases[i].n1,
                     cases[i].n2);
            expect_share(&flight, CML_FATE_SPECULAR, fresnel(cases[i].angle, cases[i].n1, cases[i].n2),
                         cases[i].photons, what);
            flight_close(&flight);
        }
}

/* ---- light that never gets out ---- */

/* Tests a pencil on the flank of a cone of 60 degrees with n = 2 and no absorption.
 *
 * Light that enters is bent to 60 - 25.7 degrees from the vertical, passes below the cone, and is totally
 * reflected for ever (beyond 30 degrees) by the planes outside. Light reflected at the flank strikes the
 * plane outside, enters more steeply, and gets out again. */
static void what_enters_a_clear_body_beyond_the_critical_angle_is_trapped(void **state)
{
    (void)state;
    for (int e = 0; e < 2; e++)
        for (int kind = CML_SURFACE_CONE; kind <= CML_SURFACE_MESH; kind++) {
            char what[64];
            struct flight flight;
            const struct flight_options with = {
                .engine = engines[e], .kind = (enum cml_surface_kind)kind, .normals = CML_NORMALS_ANALYTIC};
            flight_open("1.0\n1\ntrap A\n1\nbeam pencil at=0.05,0\n0.01 0.01\n1 1 1\n1\n1\n"
                        "b 2 0.17320508075688773 0.1 0 0\n2 0 0 0 0.5\n1\n",
                        &with, &flight);
            snprintf(what, sizeof what, "trapped, %s, %s", engines[e], cml_surface_kind_name(with.kind));
            expect_share(&flight, CML_FATE_TRAPPED, 1 - fresnel(60, 1, 2), 400, what);
            flight_close(&flight);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(beams_through_vertices_and_edges_meet_the_mesh_there),
        cmocka_unit_test(an_oblique_beam_is_shifted_and_not_turned),
        cmocka_unit_test(the_reflected_share_is_fresnels_however_small_or_grazing),
        cmocka_unit_test(what_enters_a_clear_body_beyond_the_critical_angle_is_trapped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
