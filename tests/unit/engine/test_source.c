/* Tests of where packets start and in which direction, by kernels/source.h in single precision.
 * For every shape and angular law of a beam, moments of place and direction, and their products, are
 * compared with integrals of the densities of samples/manual/input/beams.md by the midpoint rule. Random
 * sampling is judged by its own spread; the lattice must come closer. SPDX-License-Identifier: MIT */
#include "engine/world.h"
#include "lib/case_files.h"
#include "lib/require.h"
#include "input/mci.h"
#include "source.h"

#include <math.h>

static long packets = 200000; /* packets per beam; argument 1 of the program */

#define LIMIT 4.5 /* limit of |z| over all beams, moments and samplings */
enum { STEPS = 20000, PIXELS_X = 4, PIXELS_Y = 3, ROWS = 5 };
static const double pixels[PIXELS_Y][PIXELS_X] = {{0, 1, 3, 0}, {2, 0, 0, 1}, {0, 0, 5, 0}};
static const double rows[ROWS][2] = {{0, 1}, {10, 3}, {25, 0.5}, {40, 2}, {60, 0}};

enum shape { PENCIL, DISK, GAUSSIAN, RING, RECTANGLE, IMAGE };
enum light { PARALLEL, EVEN, COSINE, TABLE }; /* EVEN: uniform up to the angle `widest` */

static const struct beam {
    const char *line;
    enum shape shape;
    double size[2], middle[3], angle, azimuth;
    enum light light;
    double widest; /* largest angle, degrees */
} beams[] = {
    {"pencil light=lambertian", PENCIL, {0}, {0}, 0, 0, COSINE, 90},
    {"disk 0.1 at=0.2,-0.1 angle=40 azimuth=30", DISK, {0.1}, {0.2, -0.1}, 40, 30, PARALLEL, 0},
    {"gaussian 0.2 angle=20 light=na:0.7", GAUSSIAN, {0.2}, {0}, 20, 0, EVEN, 30},
    {"ring 0.1 0.2 light=lambertian", RING, {0.1, 0.2}, {0}, 0, 0, COSINE, 90},
    {"rectangle 0.3 0.1 angle=50 azimuth=120", RECTANGLE, {0.3, 0.1}, {0}, 50, 120, PARALLEL, 0},
    {"image \"p.gsf\" light=\"t.txt\" azimuth=300", IMAGE, {0.4, 0.15}, {0}, 0, 300, TABLE, 60},
    {"image \"p.gsf\" z=0.5 angle=35 azimuth=200 light=lambertian",
     IMAGE,
     {0.4, 0.15},
     {0, 0, 0.5},
     35,
     200,
     COSINE,
     90},
    {"disk 0.1 z=0.5 angle=110 light=na:0.7", DISK, {0.1}, {0, 0, 0.5}, 110, 0, EVEN, 30},
    {"gaussian 0.02 z=0.5 angle=180 light=na:1.4", GAUSSIAN, {0.02}, {0, 0, 0.5}, 180, 0, EVEN, 90},
    {"ring 0.1 0.2 at=-3,2 z=0.5 angle=90 light=isotropic", RING, {0.1, 0.2}, {-3, 2, 0.5}, 90, 0, EVEN, 180},
    {"rectangle 0.3 0.1 z=0.5 angle=150 azimuth=45 light=\"t.txt\"",
     RECTANGLE,
     {0.3, 0.1},
     {0, 0, 0.5},
     150,
     45,
     TABLE,
     60},
};
enum { BEAMS = sizeof beams / sizeof *beams, NUMBERS = 5 };

/* Powers of the place along the beam's own x and y, and of the direction along its own x, y and axis. */
static const int moments[][NUMBERS] = {
    {1, 0, 0, 0, 0}, {0, 1, 0, 0, 0}, {2, 0, 0, 0, 0}, {1, 1, 0, 0, 0}, {0, 2, 0, 0, 0}, {2, 2, 0, 0, 0},
    {4, 0, 0, 0, 0}, {0, 4, 0, 0, 0}, {0, 0, 1, 0, 0}, {0, 0, 0, 1, 0}, {0, 0, 2, 0, 0}, {0, 0, 1, 1, 0},
    {0, 0, 0, 2, 0}, {0, 0, 0, 0, 1}, {0, 0, 0, 0, 2}, {0, 0, 0, 0, 3}, {0, 0, 0, 0, 4}, {1, 0, 1, 0, 0},
    {0, 1, 0, 1, 0}, {2, 0, 0, 0, 1}, {0, 2, 2, 0, 0}};
enum { MOMENTS = sizeof moments / sizeof *moments };

/* ---- integrals ---- */

static double power(double x, int n)
{
    double all = 1;
    for (; n > 0; n--) all *= x;
    return all;
}

/* Returns the mean of cos^i sin^k over the circle. */
static double of_circle(int i, int k)
{
    double sum = 0;
    for (int at = 0; at < 64; at++)
        sum += power(cos(acos(-1.0) * at / 32), i) * power(sin(acos(-1.0) * at / 32), k);
    return sum / 64;
}

/* Returns the mean of x^n between a and b. */
static double between(double a, double b, int n)
{
    return (power(b, n + 1) - power(a, n + 1)) / (n + 1) / (b - a);
}

static double round_moment(const struct beam *beam, int n)
{
    const double a = beam->size[0], from = beam->shape == RING ? a : 0,
                 to = beam->shape == RING ? beam->size[1] : (beam->shape == DISK ? a : 5 * a);
    double sum = 0, all = 0;
    for (int i = 0; i < STEPS; i++) {
        const double r = from + (to - from) * (i + 0.5) / STEPS,
                     weight = r * (beam->shape == GAUSSIAN ? exp(-2 * r * r / (a * a)) : 1);
        sum += weight * power(r, n);
        all += weight;
    }
    return sum / all;
}

static double image_moment(const struct beam *beam, int i, int k)
{
    const double w = beam->size[0] / PIXELS_X, h = beam->size[1] / PIXELS_Y;
    double sum = 0, all = 0;
    for (int row = 0; row < PIXELS_Y; row++)
        for (int column = 0; column < PIXELS_X; column++) {
            const double x = w * (column - 0.5 * PIXELS_X), y = h * (0.5 * PIXELS_Y - row - 1);
            sum += pixels[row][column] * between(x, x + w, i) * between(y, y + h, k);
            all += pixels[row][column];
        }
    return sum / all;
}

static double place_moment(const struct beam *beam, int i, int k)
{
    const double a = beam->size[0] / 2, b = beam->size[1] / 2;
    if (beam->shape == PENCIL) return i + k == 0;
    if (beam->shape == IMAGE) return image_moment(beam, i, k);
    if (beam->shape == RECTANGLE) return between(-a, a, i) * between(-b, b, k);
    return round_moment(beam, i + k) * of_circle(i, k);
}

static double intensity(enum light light, int row, double t)
{
    const double a = rows[row][0] / 180 * acos(-1.0), b = rows[row + 1][0] / 180 * acos(-1.0);
    if (light != TABLE) return light == COSINE ? cos(t) : 1;
    return rows[row][1] + (rows[row + 1][1] - rows[row][1]) * (t - a) / (b - a);
}

/* Returns the mean of sin^i cos^k of the angle between light and the beam's axis. */
static double light_moment(const struct beam *beam, int i, int k)
{
    const int parts = beam->light == TABLE ? ROWS - 1 : 1;
    double sum = 0, all = 0;
    if (beam->light == PARALLEL) return i == 0;
    for (int row = 0; row < parts; row++) {
        const double from = beam->light == TABLE ? rows[row][0] : 0,
                     to = beam->light == TABLE ? rows[row + 1][0] : beam->widest;
        for (int at = 0; at < STEPS; at++) {
            const double t = (from + (to - from) * (at + 0.5) / STEPS) / 180 * acos(-1.0);
            const double weight = intensity(beam->light, row, t) * sin(t) * (to - from);
            sum += weight * power(sin(t), i) * power(cos(t), k);
            all += weight;
        }
    }
    return sum / all;
}

static double expected(const struct beam *beam, const int *n)
{
    return place_moment(beam, n[0], n[1]) * light_moment(beam, n[2] + n[3], n[4]) * of_circle(n[2], n[3]);
}

/* ---- packets ---- */

/* Reads a clear layer between equal media, one run per beam. */
static void read_scenes(void **state, struct cml_scene_list *list)
{
    struct cml_error err;
    char path[256], text[4096], angles[256] = "";
    const char *head =
        "Gwyddion Simple Field 1.0\nXRes = 4\nYRes = 3\nXReal = 4\nYReal = 1.5\nXYUnits = mm\n";
    unsigned char field[256] = {0};
    const size_t size = (strlen(head) / 4 + 1) * 4;
    memcpy(field, head, strlen(head));
    for (int i = 0; i < PIXELS_X * PIXELS_Y; i++) {
        const float value = (float)pixels[i / PIXELS_X][i % PIXELS_X];
        memcpy(field + size + 4 * (size_t)i, &value, 4);
    }
    case_write_bytes(state, "p.gsf", (const char *)field, size + 4 * PIXELS_X * PIXELS_Y);
    for (int i = 0, n = 0; i < ROWS; i++)
        n += snprintf(angles + n, sizeof angles - (size_t)n, "%g %g\n", rows[i][0], rows[i][1]);
    case_write(state, "t.txt", angles);
    int n = snprintf(text, sizeof text, "1.0\n%d\n", BEAMS);
    for (int i = 0; i < BEAMS; i++)
        n += snprintf(text + n, sizeof text - (size_t)n,
                      "x%d A\n1\nbeam %s\n1 1\n1 1 1\n1\n1.4\n1.4 0 0 0 1\n1.4\n", i, beams[i].line);
    case_write(state, "x.mci", text);
    case_path(state, "x.mci", path);
    require_ok(cml_mci_read(path, NULL, list, &err), &err);
    case_remove(state, "x.mci");
    case_remove(state, "t.txt");
    case_remove(state, "p.gsf");
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Computes the beam's own x, own y and axis, as defined in samples/manual/input/beams.md. */
static void axes_of(const struct beam *beam, double axes[3][3])
{
    const double a = beam->angle / 180 * acos(-1.0), p = beam->azimuth / 180 * acos(-1.0);
    const double all[3][3] = {{cos(a) * cos(p), cos(a) * sin(p), -sin(a)},
                              {-sin(p), cos(p), 0},
                              {sin(a) * cos(p), sin(a) * sin(p), cos(a)}};
    memcpy(axes, all, sizeof all);
}

/* Computes the numbers whose moments are compared: the point where the packet's line crosses the plane of
 * the shape, and the packet's direction. */
static void numbers_of(const struct cml_world *world, const struct beam *beam, double axes[3][3],
                       uint64_t index, double *to)
{
    struct cml_packet packet;
    cml_place(world, index, &packet);
    const double u[3] = {(double)packet.u.x, (double)packet.u.y, (double)packet.u.z};
    double off[3] = {(double)packet.p.x + (double)world->setup.x0 - beam->middle[0],
                     (double)packet.p.y + (double)world->setup.y0 - beam->middle[1],
                     (double)packet.p.z + (double)world->media[packet.medium].depth - beam->middle[2]};
    const double to_plane = dot(off, axes[2]) / dot(u, axes[2]);
    if (beam->middle[2] > 0) {
        if (fabs(dot(off, axes[2])) > 1e-6) fail_msg("%s: starts %g off", beam->line, dot(off, axes[2]));
    } else {
        for (int k = 0; k < 3; k++) off[k] -= to_plane * u[k];
    }
    for (int k = 0; k < 2; k++) to[k] = dot(off, axes[k]);
    for (int k = 0; k < 3; k++) to[2 + k] = dot(u, axes[k]);
}

static double worst;

static void hold(const struct beam *beam, const int *n, double sum, double squares)
{
    const double mean = sum / (double)packets, truth = expected(beam, n), scale = pow(0.3, n[0] + n[1]);
    const double error = sqrt(fmax(0, squares / (double)packets - mean * mean) / (double)packets),
                 rounding = 3e-7 * scale, z = fmax(0, fabs(mean - truth) - rounding) / (error + 1e-30);
    worst = fmax(worst, z);
    if (z > LIMIT)
        fail_msg("%s: moment %d %d %d %d %d is %.9g, not %.9g (z = %.2f)", beam->line, n[0], n[1], n[2], n[3],
                 n[4], mean, truth, z);
}

static void fly(const struct cml_world *world, const struct beam *beam)
{
    double sum[MOMENTS] = {0}, squares[MOMENTS] = {0}, axes[3][3];
    axes_of(beam, axes);
    for (uint64_t index = 0; index < (uint64_t)packets; index++) {
        double x[NUMBERS], powers[NUMBERS][5];
        numbers_of(world, beam, axes, index, x);
        for (int k = 0; k < NUMBERS; k++)
            for (int n = 0; n < 5; n++) powers[k][n] = n ? powers[k][n - 1] * x[k] : 1;
        for (int m = 0; m < MOMENTS; m++) {
            double value = 1;
            for (int k = 0; k < NUMBERS; k++) value *= powers[k][moments[m][k]];
            sum[m] += value;
            squares[m] += value * value;
        }
    }
    for (int m = 0; m < MOMENTS; m++) hold(beam, moments[m], sum[m], squares[m]);
}

static void fly_all(void **state, bool lattice)
{
    struct cml_scene_list list;
    const struct cml_surface_options surface = {.force = CML_SURFACE_AUTO,
                                                .tessellation = {.tolerance = 1e-3}};
    const struct cml_engine_options options = {
        .seed = 33, .threads = 1, .lattice = lattice, .roulette = {0.01, 0.03}};
    worst = 0;
    read_scenes(state, &list);
    for (int i = 0; i < BEAMS; i++) {
        struct cml_error err;
        struct cml_surface_set surfaces;
        struct cml_owned_world world;
        require_ok(cml_surfaces_create(&list.scenes[i], &surface, &surfaces, &err), &err);
        require_ok(cml_owned_world_create(&list.scenes[i], &surfaces, &options, &world, &err), &err);
        fly(&world.world, &beams[i]);
        cml_owned_world_free(&world);
        cml_surfaces_free(&surfaces);
    }
    cml_scene_list_clear(&list);
    print_message("%d moments of %ld packets each: the worst |z| is %.2f\n", BEAMS * MOMENTS, packets, worst);
}

static void random_beams_have_the_moments_of_their_densities(void **state)
{
    fly_all(state, false);
}

static void spread_beams_have_the_moments_of_their_densities(void **state)
{
    fly_all(state, true);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(random_beams_have_the_moments_of_their_densities, case_setup,
                                        case_teardown),
        cmocka_unit_test_setup_teardown(spread_beams_have_the_moments_of_their_densities, case_setup,
                                        case_teardown),
    };
    if (argc > 1) packets = atol(argv[1]);
    return cmocka_run_group_tests_name("source", tests, NULL, NULL);
}
