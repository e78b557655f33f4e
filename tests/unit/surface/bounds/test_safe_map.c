/* Tests of safe distances and safe paths against all facets in long double. Random sheets with overhangs,
 * 0.01 to 10 cm wide, lie under beams and layers that cost digits. Paths are random, or aimed at the
 * closest place of the surface. SPDX-License-Identifier: MIT */
#include "lib/bench.h"
#include "lib/dice.h"
#include "lib/mci_case.h"

#include "engine/world_parts.h"
#include "surface_hit.h"

#define SIDE 7 /* cells of a sheet along an axis */
#define CORNERS ((SIDE + 1) * (SIDE + 1))
#define FACETS (2 * SIDE * SIDE)
#define SCENES 8
#define BORDER (4 * SIDE)

typedef long double place[3];

struct sheet {
    double vertex[CORNERS][3];
    int facet[FACETS][3], border[BORDER];
};

static int corner_at(int i, int j)
{
    return i * (SIDE + 1) + j;
}

/* Makes a rough patch over a parallelogram, sheared until it has overhangs. Heights are positive up, as in
 * files. */
static void make_sheet(struct dice *dice, double size, struct sheet *sheet)
{
    const double lean = dice_between(dice, 2, 4), askew = dice_between(dice, -0.5, 0.5);
    for (int i = 0; i <= SIDE; i++)
        for (int j = 0; j <= SIDE; j++) {
            const bool border = i == 0 || j == 0 || i == SIDE || j == SIDE;
            const double h = border ? 0 : dice_between(dice, -0.15, 0.2);
            double *v = sheet->vertex[corner_at(i, j)];
            v[0] = size * ((double)i / SIDE - 0.5 + lean * h);
            v[1] = size * ((double)j / SIDE - 0.5) + askew * v[0];
            v[2] = size * h;
        }
    for (int i = 0, k = 0; i < SIDE; i++)
        for (int j = 0; j < SIDE; j++, k += 2) {
            const int a = corner_at(i, j), b = corner_at(i + 1, j), c = b + 1, d = a + 1;
            const int two[2][3] = {{a, b, c}, {a, c, d}};
            memcpy(sheet->facet[k], two, sizeof two);
        }
    for (int i = 0; i < SIDE; i++) {
        sheet->border[i] = corner_at(i, 0);
        sheet->border[SIDE + i] = corner_at(SIDE, i);
        sheet->border[2 * SIDE + i] = corner_at(SIDE - i, SIDE);
        sheet->border[3 * SIDE + i] = corner_at(0, SIDE - i);
    }
}

static void write_sheet(void **state, const char *name, const struct sheet *sheet)
{
    char text[20000], *at = text;
    for (int i = 0; i < CORNERS; i++) {
        const double *v = sheet->vertex[i];
        at += sprintf(at, "v %.17g %.17g %.17g\n", v[0], v[1], v[2]);
    }
    for (int i = 0; i < FACETS; i++) {
        const int *f = sheet->facet[i];
        at += sprintf(at, "f %d %d %d\n", f[0] + 1, f[1] + 1, f[2] + 1);
    }
    case_write(state, name, text);
}

static long double dot(const place a, const place b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void between(const place a, const place b, place way)
{
    for (int k = 0; k < 3; k++) way[k] = b[k] - a[k];
}

static void cross(const place a, const place b, place out)
{
    for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Computes vertex i in the boundary's frame: z down, counted from x0, y0. */
static void vertex_of(const struct sheet *sheet, int i, const double origin[2], place v)
{
    v[0] = (long double)sheet->vertex[i][0] - origin[0];
    v[1] = (long double)sheet->vertex[i][1] - origin[1];
    v[2] = -(long double)sheet->vertex[i][2];
}

/* Keeps the place `at` if it is closer to p than the closest one so far. */
static void keep_closest(const place p, const place at, long double *least, place closest)
{
    place way;
    between(p, at, way);
    const long double distance = sqrtl(dot(way, way));
    if (distance >= *least) return;
    *least = distance;
    memcpy(closest, at, sizeof(place));
}

static void closest_on_edge(const place p, const place a, const place b, long double *least, place closest)
{
    place edge, from, at;
    between(a, b, edge);
    between(a, p, from);
    const long double t = fmaxl(0, fminl(1, dot(from, edge) / dot(edge, edge)));
    for (int k = 0; k < 3; k++) at[k] = a[k] + t * edge[k];
    keep_closest(p, at, least, closest);
}

static void closest_on_facet(const place p, place corner[3], long double *least, place closest)
{
    place u, v, normal, from, at, part;
    for (int k = 0; k < 3; k++) closest_on_edge(p, corner[k], corner[(k + 1) % 3], least, closest);
    between(corner[0], corner[1], u);
    between(corner[0], corner[2], v);
    between(corner[0], p, from);
    cross(u, v, normal);
    const long double square = dot(normal, normal), height = dot(from, normal) / square;
    cross(from, v, part);
    const long double second = dot(part, normal) / square;
    cross(u, from, part);
    const long double third = dot(part, normal) / square;
    for (int k = 0; k < 3; k++) at[k] = p[k] - height * normal[k];
    if (second >= 0 && third >= 0 && second + third <= 1) keep_closest(p, at, least, closest);
}

/* True if the border, seen from above, goes around the place. */
static bool is_inside_border(const struct sheet *sheet, const double origin[2], const place p)
{
    bool inside = false;
    for (int i = 0; i < BORDER; i++) {
        place a, b;
        vertex_of(sheet, sheet->border[i], origin, a);
        vertex_of(sheet, sheet->border[(i + 1) % BORDER], origin, b);
        if ((a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
            inside = !inside;
    }
    return inside;
}

/* Returns the distance from p to the sheet or the plane around it, and the closest place. */
static long double distance_to(const struct sheet *sheet, const double origin[2], const place p,
                               place closest)
{
    long double least = INFINITY;
    const place below = {p[0], p[1], 0};
    for (int i = 0; i < FACETS; i++) {
        place corner[3];
        for (int k = 0; k < 3; k++) vertex_of(sheet, sheet->facet[i][k], origin, corner[k]);
        closest_on_facet(p, corner, &least, closest);
    }
    if (!is_inside_border(sheet, origin, p)) keep_closest(p, below, &least, closest);
    return least;
}

/* Returns six times the volume of a tetrahedron. */
static long double volume(const place a, const place b, const place c, const place d)
{
    place ab, ac, ad, normal;
    between(a, b, ab);
    between(a, c, ac);
    between(a, d, ad);
    cross(ab, ac, normal);
    return dot(normal, ad);
}

/* Returns how often the way from p to q crosses the sheet or the plane around it. */
static int crossings(const struct sheet *sheet, const double origin[2], const place p, const place q)
{
    int count = 0;
    for (int i = 0; i < FACETS; i++) {
        place c[3];
        for (int k = 0; k < 3; k++) vertex_of(sheet, sheet->facet[i][k], origin, c[k]);
        if ((volume(c[0], c[1], c[2], p) > 0) == (volume(c[0], c[1], c[2], q) > 0)) continue;
        const bool first = volume(p, q, c[0], c[1]) > 0, second = volume(p, q, c[1], c[2]) > 0,
                   third = volume(p, q, c[2], c[0]) > 0;
        count += first == second && second == third;
    }
    if ((p[2] > 0) == (q[2] > 0)) return count;
    place at;
    for (int k = 0; k < 3; k++) at[k] = p[k] + p[2] / (p[2] - q[2]) * (q[k] - p[k]);
    return count + !is_inside_border(sheet, origin, at);
}

/* A scene with two sheets, one at the top and one below the first layer. */
struct scene {
    struct bench bench;
    struct cml_owned_world owned;
    struct sheet sheet[2];
    double size, origin[2];
};

static void open_scene(void **state, uint32_t seed, struct scene *scene)
{
    struct dice dice = dice_new(seed);
    struct cml_error err;
    char text[1024], folder[256];
    const struct cml_surface_options asked = {.force = CML_SURFACE_AUTO, .tessellation.tolerance = 1e-3};
    scene->size = pow(10, dice_between(&dice, -2, 1));
    for (int k = 0; k < 2; k++) scene->origin[k] = scene->size * dice_between(&dice, -3, 3);
    const double thickness = scene->size * pow(10, dice_between(&dice, 0.2, 1.5));
    make_sheet(&dice, scene->size, &scene->sheet[0]);
    make_sheet(&dice, scene->size, &scene->sheet[1]);
    write_sheet(state, "0.obj", &scene->sheet[0]);
    write_sheet(state, "1.obj", &scene->sheet[1]);
    case_path(state, "", folder);
    snprintf(text, sizeof text,
             "1.0\n1\nx.mco A\n10\nbeam pencil at=%.17g,%.17g\n1 1\n1 1 1\n2\n1\nm \"%s0.obj\"\n"
             "1.4 1 9 0 %.17g\nm \"%s1.obj\"\n1.3 1 9 0 %.17g\n1\n",
             scene->origin[0], scene->origin[1], folder, thickness, folder, scene->size);
    scene->bench = (struct bench){.options = bench_options(1)};
    case_read_ok(state, text, &scene->bench.list);
    require_ok(cml_surfaces_create(scene->bench.list.scenes, &asked, &scene->bench.surfaces, &err), &err);
    require_ok(cml_owned_world_create(scene->bench.list.scenes, &scene->bench.surfaces, &scene->bench.options,
                                      &scene->owned, &err),
               &err);
    case_remove(state, "0.obj");
    case_remove(state, "1.obj");
}

static void close_scene(struct scene *scene)
{
    cml_owned_world_free(&scene->owned);
    tear_down(&scene->bench);
}

/* Returns the safe map of boundary b. *corner: first corner of the map, from the beam's axis. */
static const struct cml_safe_map *map_of(const struct scene *scene, int b, double corner[3])
{
    const struct cml_mesh_surface *mesh = scene->bench.surfaces.item[b].mesh;
    const struct cml_safe_map *map = cml_mesh_surface_map(mesh);
    assert_non_null(map);
    cml_mesh_surface_mesh(mesh, corner);
    for (int k = 0; k < 3; k++) corner[k] += map->corner[k] - (k < 2 ? scene->origin[k] : 0);
    return map;
}

/* Computes the middle of a cell, from the beam's axis. */
static void middle_of(const struct scene *scene, int b, const int cell[3], place middle)
{
    double corner[3];
    const struct cml_safe_map *map = map_of(scene, b, corner);
    for (int k = 0; k < 3; k++)
        middle[k] = (long double)corner[k] + (cell[k] + 0.5L) * (long double)map->cell;
}

static void no_ball_holds_a_part_of_the_surface(void **state)
{
    static struct scene scene;
    long balls = 0, exact = 0;
    for (uint32_t seed = 1; seed <= SCENES; seed++) {
        open_scene(state, seed, &scene);
        double corner[3];
        const struct cml_safe_map *map = map_of(&scene, 0, corner);
        const float *safe = map->safe;
        int cell[3];
        for (cell[2] = 0; cell[2] < map->n[2]; cell[2]++)
            for (cell[1] = 0; cell[1] < map->n[1]; cell[1]++)
                for (cell[0] = 0; cell[0] < map->n[0]; cell[0]++, safe++) {
                    if ((seed + (uint32_t)(safe - map->safe)) % (SCENES * SANITIZED_STEP)) continue;
                    place p, closest;
                    middle_of(&scene, 0, cell, p);
                    const double there =
                        (double)(distance_to(&scene.sheet[0], scene.origin, p, closest) / map->cell);
                    balls++;
                    exact += (double)*safe > 0.9999 * there;
                    if ((double)*safe > there || (double)*safe < 0.75 * there)
                        fail_msg("seed %u, cell %d %d %d: %.9g instead of %.9g cells", seed, cell[0], cell[1],
                                 cell[2], (double)*safe, there);
                }
        close_scene(&scene);
    }
    print_message("%ld balls, %ld of them exact\n", balls, exact);
    assert_true(exact > balls / 3);
}

/* A path in a packet's precision. */
struct path {
    struct cml_vec p, u;
    real s;
};

static int is_safe(const struct scene *scene, int b, const struct path *path)
{
    const struct cml_world *world = &scene->owned.world;
    return cml_is_safe(world, &world->surfaces[b], path->p, path->u, path->s);
}

/* Returns the path from a to b, rounded like those of packets. */
static struct path path_between(const place a, const place b)
{
    place way;
    between(a, b, way);
    const long double s = sqrtl(dot(way, way)), k = s > 0 ? 1 / s : 0;
    const struct path path = {cml_vec_of((double)a[0], (double)a[1], (double)a[2]),
                              cml_vec_of((double)(k * way[0]), (double)(k * way[1]), (double)(k * way[2])),
                              (real)s};
    return path;
}

/* Checks a path that the map calls safe: it meets nothing, and its ends are further from the surface than
 * any tolerance of a query. These tolerances grow with the layer's thickness. */
static void expect_safe(const struct scene *scene, int b, const struct path *path, const char *what)
{
    const struct sheet *sheet = &scene->sheet[b];
    const place p = {path->p.x, path->p.y, path->p.z},
                q = {p[0] + (long double)path->s * path->u.x, p[1] + (long double)path->s * path->u.y,
                     p[2] + (long double)path->s * path->u.z};
    const double span = (double)scene->owned.media[b].span;
    place closest;
    for (int end = 0; end < 2; end++) {
        const long double *at = end ? q : p;
        const double least = 32 * cml_err_position((double)at[0], (double)at[1], (double)at[2], span),
                     there = (double)distance_to(sheet, scene->origin, at, closest);
        if (there < least)
            fail_msg("%s: boundary %d, end %d: %g from the surface, not %g", what, b, end, there, least);
    }
    if (crossings(sheet, scene->origin, p, q)) fail_msg("%s: boundary %d: a safe path meets it", what, b);
}

static void a_safe_path_meets_nothing(void **state)
{
    static struct scene scene;
    long thrown = 0, safe = 0;
    for (uint32_t seed = 1; seed <= SCENES; seed++) {
        struct dice dice = dice_new(100 + seed);
        open_scene(state, seed, &scene);
        for (int i = 0; i < repeats(20000); i++, thrown++) {
            const int b = i & 1;
            double u[3], corner[3];
            const struct cml_safe_map *map = map_of(&scene, b, corner);
            dice_direction(&dice, u);
            struct path path = {.u = cml_vec_of(u[0], u[1], u[2])};
            double at[3];
            for (int k = 0; k < 3; k++)
                at[k] = corner[k] + dice_between(&dice, -0.1, 1.1) * map->n[k] * map->cell;
            path.p = cml_vec_of(at[0], at[1], at[2]);
            path.s = (real)(scene.size * pow(10, dice_between(&dice, -4, 0.5)));
            if (!is_safe(&scene, b, &path)) continue;
            safe++;
            expect_safe(&scene, b, &path, "thrown");
        }
        close_scene(&scene);
    }
    print_message("%ld of %ld paths are safe\n", safe, thrown);
    assert_true(safe > thrown / 4);
}

/* Paths lead from around the middle of a cell to the closest place of the surface. None that ends on the
 * surface is safe; most of those that end a little before it are. */
static void a_path_up_to_the_surface_is_not_safe(void **state)
{
    static struct scene scene;
    long safe = 0, short_of_it = 0;
    for (uint32_t seed = 1; seed <= SCENES; seed++) {
        struct dice dice = dice_new(200 + seed);
        open_scene(state, seed, &scene);
        for (int i = 0; i < repeats(2000); i++) {
            const int b = i & 1;
            double corner[3];
            const struct cml_safe_map *map = map_of(&scene, b, corner);
            const int cell[3] = {dice_below(&dice, map->n[0]), dice_below(&dice, map->n[1]),
                                 dice_below(&dice, map->n[2])};
            place middle, closest, from, to;
            middle_of(&scene, b, cell, middle);
            const long double there = distance_to(&scene.sheet[b], scene.origin, middle, closest) / map->cell,
                              margin = scene.owned.safe_cells[b].margin / there,
                              almost = 1 - margin * dice_between(&dice, 0, 1.5),
                              share = (i & 2) ? 1 : ((i & 8) ? almost : 0.97L - 4 * margin);
            const long double off = (i & 4) ? 0 : 0.4L * dice_between(&dice, -1, 1);
            for (int k = 0; k < 3; k++) {
                to[k] = middle[k] + share * (closest[k] - middle[k]);
                from[k] = middle[k] - (share + off) * (closest[k] - middle[k]);
            }
            const struct path path = path_between(from, to);
            const int found = is_safe(&scene, b, &path);
            if (found) expect_safe(&scene, b, &path, "aimed");
            if (share == 1) assert_false(found);
            if (share > 0.97L || off > 0) continue;
            short_of_it++;
            safe += found;
        }
        close_scene(&scene);
    }
    print_message("%ld of %ld paths that end before the surface are safe\n", safe, short_of_it);
    assert_true(safe > short_of_it / 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(no_ball_holds_a_part_of_the_surface, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(a_safe_path_meets_nothing, case_setup, case_teardown),
        cmocka_unit_test_setup_teardown(a_path_up_to_the_surface_is_not_safe, case_setup, case_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
