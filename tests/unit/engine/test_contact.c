/* Tests which face or port holds a place of boundary 0: the grid of the walk against all lines in turn, at
 * random places and at every rim; and what becomes of packets that are aimed at rims.
 * SPDX-License-Identifier: MIT */
#include "engine/world.h"
#include "lib/case_files.h"
#include "lib/dice.h"
#include "lib/require.h"
#include "input/mci.h"
#include "walk.h"

#include <math.h>

#define FACES "face rectangle 1 0.8 0.5 at=0.1,0\nface disk 0.2 0 at=-0.3,0.1\nface ring 0.2 0.3 metal 2 3\n"
#define PORTS                                                                                                \
    "port disk 0.05 n=1.44 at=0.1,0.1\nport disk 0.04 n=1.46 at=0.1,0.1\nport ring 0.04 0.06 n=1 "           \
    "at=-0.2,0\n"                                                                                            \
    "port rectangle 0.1 0.05 n=1.3 at=0.3,-0.2\nport disk 0.7 n=1.2 at=3,2\n"
static const char *const tops[] = {FACES PORTS, PORTS FACES, FACES "face 0.3 lambertian\n" PORTS,
                                   "face 0.3\n"};
enum { TOPS = sizeof tops / sizeof *tops };

/* Returns the number of the last line that holds a place, 0: none, by the scene itself, in double precision.
 * *gap: the smallest distance from a rim, cm. */
static int held_by(const struct cml_scene *scene, double x, double y, double *gap)
{
    int found = 0;
    *gap = INFINITY;
    for (int k = 0; k < scene->num_contacts; k++) {
        const struct cml_contact_def *c = &scene->contacts[k];
        const double dx = x - c->x, dy = y - c->y, r = hypot(dx, dy), *size = c->size;
        const double out = c->shape == CML_DETECTOR_RING
                               ? fmax(r - size[1], size[0] > 0 ? size[0] - r : -INFINITY)
                               : fmax(fabs(dx) - size[0] / 2, fabs(dy) - size[1] / 2);
        if (c->whole || out < 0) found = k + 1;
        if (!c->whole) *gap = fmin(*gap, fabs(out));
    }
    return found;
}

/* Aims a packet from below at a place, and checks that what holds the place decides what becomes of it. */
static void meet(const struct cml_world *world, const struct cml_scene *scene, real x, real y, cml_u64 index)
{
    const struct cml_hit hit = {
        .t = 0.1f, .boundary = 0, .point = {x, y, 0}, .normal = {0, 0, -1}, .facet = {0, 0, -1}};
    const real uz = -0.8f;
    struct cml_packet packet = {
        .index = index, .u = {0.6f, 0, uz}, .w = CML_WEIGHT_ONE, .medium = 1, .entered = 1, .tau = 1};
    const int number = cml_contact_at(world, x, y);
    const struct cml_contact_def *contact = number ? &scene->contacts[number - 1] : NULL;
    cml_boundary_event(world, &packet, &hit);
    if (contact && !contact->port) {
        assert_true(packet.medium == 1 && packet.u.z > 0);
        assert_true(contact->face.kind == CML_BACKING_METAL
                        ? packet.face > 0
                        : fabs((double)packet.face / CML_WEIGHT_ONE - (1 - contact->face.R)) < 1e-6);
        assert_true(packet.w + packet.face == CML_WEIGHT_ONE);
    } else if (packet.medium == 0) {
        const double n = contact ? contact->n : scene->media[0].n;
        assert_true(fabs(n * (double)packet.u.x - scene->media[1].n * 0.6) < 1e-6);
        assert_int_equal(packet.fate, CML_FATE_REFLECTED);
        assert_true(packet.w == CML_WEIGHT_ONE);
    } else {
        assert_true(packet.u.z == -uz && packet.face == 0);
    }
}

/* Checks a place. Within rounding of a rim either side is right. */
static void check_place(const struct cml_world *world, const struct cml_scene *scene, real x, real y,
                        cml_u64 index)
{
    double gap;
    const int wanted =
        held_by(scene, (double)x + (double)world->setup.x0, (double)y + (double)world->setup.y0, &gap);
    if (gap > 1e-6) assert_int_equal(cml_contact_at(world, x, y), wanted);
    meet(world, scene, x, y, index);
}

/* Checks places on, before and beyond the rim of contact k, all around. */
static void check_rim(const struct cml_world *world, const struct cml_scene *scene, int k, cml_u64 *index)
{
    static const double factors[] = {0.999, 1 - 1e-6, 1, 1 + 1e-6, 1.001};
    const struct cml_contact_def *c = &scene->contacts[k];
    for (int i = 0; i < 64 * 5 * 2; i++) {
        const double turn = 6.283185307179586 * (i % 64) / 64, by = factors[i / 64 % 5], s = sin(turn),
                     t = cos(turn);
        const double r = c->size[i / 320] * by, side = 0.5 * by / fmax(fabs(s), fabs(t));
        const bool round = c->shape == CML_DETECTOR_RING;
        const double x = c->x + (round ? r * t : c->size[0] * side * t),
                     y = c->y + (round ? r * s : c->size[1] * side * s);
        check_place(world, scene, (real)(x - (double)world->setup.x0), (real)(y - (double)world->setup.y0),
                    (*index)++);
    }
}

/* A scene with lines on top, and its world. */
struct probe {
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct cml_owned_world owned;
};

static void set_up(void **state, const char *top, struct probe *probe)
{
    const struct cml_surface_options surface = {0};
    const struct cml_engine_options options = {.seed = 1};
    struct cml_error err;
    char text[1000];
    snprintf(text, sizeof text,
             "1.0\n1\nt A\n1\nbeam pencil z=0.05 light=isotropic\n0.1 0.1\n9 9 1\n1\n1.0\n%s1.4 1 10 0.5 "
             "1\n1.0\n",
             top);
    case_write(state, "t.mci", text);
    require_ok(cml_mci_read(case_in_directory(state, "t.mci"), NULL, &probe->list, &err), &err);
    require_ok(cml_surfaces_create(probe->list.scenes, &surface, &probe->surfaces, &err), &err);
    require_ok(cml_owned_world_create(probe->list.scenes, &probe->surfaces, &options, &probe->owned, &err),
               &err);
    case_remove(state, "t.mci");
}

static void tear_down(struct probe *probe)
{
    cml_owned_world_free(&probe->owned);
    cml_surfaces_free(&probe->surfaces);
    cml_scene_list_clear(&probe->list);
}

static void every_place_belongs_to_the_last_line_that_holds_it(void **state)
{
    struct dice dice = dice_new(7);
    cml_u64 index = 0;
    for (int i = 0; i < TOPS; i++) {
        struct probe probe;
        set_up(state, tops[i], &probe);
        const struct cml_scene *scene = probe.list.scenes;
        const struct cml_world *world = &probe.owned.world;
        for (int k = 0; k < scene->num_contacts; k++)
            if (!scene->contacts[k].whole) check_rim(world, scene, k, &index);
        for (int k = 0; k < 20000; k++)
            check_place(world, scene, (real)(2 * dice_uniform(&dice) - 1),
                        (real)(2 * dice_uniform(&dice) - 1), index++);
        tear_down(&probe);
    }
}

/* Radii whose squares single precision has, so places on rims are exact. */
static void no_outer_rim_belongs_to_its_shape(void **state)
{
    struct probe probe;
    set_up(state, "port disk 0.5 n=1.5\nport ring 0.75 1 n=1.5\nport rectangle 0.5 0.5 n=1.5 at=2,0\n",
           &probe);
    const struct cml_world *world = &probe.owned.world;
    assert_true(world->setup.x0 == 0 && world->setup.y0 == 0);
    assert_int_equal(cml_contact_at(world, 0.5f, 0), 0);
    assert_int_equal(cml_contact_at(world, 0, -0.4999999f), 1);
    assert_int_equal(cml_contact_at(world, 0.75f, 0), 2);
    assert_int_equal(cml_contact_at(world, 0, 1), 0);
    assert_int_equal(cml_contact_at(world, 1.75f, -0.25f), 3);
    assert_int_equal(cml_contact_at(world, 2.25f, 0), 0);
    tear_down(&probe);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_place_belongs_to_the_last_line_that_holds_it, case_setup,
                                        case_teardown),
        cmocka_unit_test_setup_teardown(no_outer_rim_belongs_to_its_shape, case_setup, case_teardown)};
    return cmocka_run_group_tests_name("contact", tests, NULL, NULL);
}
