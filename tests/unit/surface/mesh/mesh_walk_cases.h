/* A long walk of packets on both sides of a rough mesh, compiled once in float and once in double. The
 * walk flips its side at each crossing and never looks it up. The regular grid of the patch tells, without
 * a search, on which side the packet really is. SPDX-License-Identifier: MIT */
#include "lib/mesh_shapes.h"
#include "surface/mesh/mesh_surface.h"
#include "walk.h"

static const double eps = (double)CML_EPSILON;

struct walker {
    struct patch patch;
    struct cml_world world;
    struct cml_packet packet;
    double side;
    long crossings, flights, wrong;
    double worst; /* deepest place on the wrong side, cm */
};

static struct cml_vec random_direction(struct dice *dice)
{
    double u[3];
    dice_direction(dice, u);
    const struct cml_vec v = {(real)u[0], (real)u[1], (real)u[2]};
    return v;
}

static double height(const struct walker *walker)
{
    const struct cml_vec p = walker->packet.p;
    return walker->side * ((double)p.z - patch_depth(&walker->patch, (double)p.x, (double)p.y));
}

static void place(struct dice *dice, struct walker *walker)
{
    struct cml_packet *packet = &walker->packet;
    packet->p.x = (real)dice_between(dice, -1.2, 1.2);
    packet->p.y = (real)dice_between(dice, -1.2, 1.2);
    packet->p.z = (real)dice_between(dice, -0.2, 0.2);
    packet->u = random_direction(dice);
    packet->on_primitive = -1;
    walker->side = 1;
    walker->side = height(walker) > 0 ? 1 : -1;
}

/* Checks that the packet is on its side, beyond the rounding of its position. */
static void look(struct dice *dice, struct walker *walker)
{
    const double inside = height(walker);
    if (inside >= 0) return;
    walker->worst = fmax(walker->worst, -inside);
    if (inside > -64 * eps) return;
    walker->wrong++;
    place(dice, walker);
}

static void cross(struct dice *dice, struct walker *walker, const struct cml_hit *hit)
{
    static const double index[][2] = {{1, 1}, {1, 1.4}, {1.4, 1}, {1, 3}};
    const double *n = index[dice_below(dice, COUNT(index))];
    walker->packet.undeflected = n[0] == n[1];
    const int transmitted =
        walker->packet.undeflected || cml_reflect_or_refract(&walker->world, &walker->packet, hit,
                                                             (real)walker->side, (real)n[0], (real)n[1]);
    if (transmitted) walker->side = -walker->side;
    walker->crossings++;
}

static void fly(struct dice *dice, struct walker *walker)
{
    struct cml_packet *packet = &walker->packet;
    const double free_path = -log(dice_uniform(dice)) * (dice_below(dice, 2) ? 1 : 0.02);
    struct cml_hit hit = {.t = (real)free_path};
    int ends_near_facet;
    walker->flights++;
    const int found =
        cml_intersect_mesh(&walker->world, 0, packet->p, packet->u, (real)walker->side, (real)free_path,
                           packet->on_primitive, packet->undeflected, &hit, &ends_near_facet);
    packet->p = found ? hit.point : cml_along(packet->p, hit.t, packet->u);
    packet->on_primitive = found ? hit.primitive : (ends_near_facet ? CML_NEAR_FACETS : -1);
    look(dice, walker);
    if (found) {
        cross(dice, walker, &hit);
    } else {
        packet->u = random_direction(dice);
        if (dice_below(dice, 4) && walker->side * (double)packet->u.z > 0) packet->u.z = -packet->u.z;
    }
    if (fabs((double)packet->p.x) > 1.5 || fabs((double)packet->p.y) > 1.5 || fabs((double)packet->p.z) > 0.3)
        place(dice, walker);
}

static void check_walk(uint32_t seed, double roughness, enum cml_mesh_search search, long flights)
{
    struct dice dice = dice_new(seed);
    static struct walker walker;
    memset(&walker, 0, sizeof walker);
    patch_make(&walker.patch, seed, roughness, 0, 0, 0);
    struct cml_mesh mesh = patch_mesh(&walker.patch);
    struct cml_mesh_surface *surface = NULL;
    struct cml_error err;
    assert_int_equal(cml_mesh_surface_create(&mesh, 0, 0, search, &surface, &err), CML_OK);
    const struct cml_mesh_surface *const meshes[] = {surface};
    const struct cml_surface surfaces[] = {{.kind = CML_SURFACE_MESH}};
    const struct cml_medium media[] = {{.n = 1}};
    walker.world.media = media;
    walker.world.meshes = meshes;
    walker.world.intersect_mesh = cml_mesh_surface_hit;
    walker.world.surfaces = surfaces;
    place(&dice, &walker);
    for (long n = 0; n < flights; n++) fly(&dice, &walker);
    printf("%ld flights, %ld crossings, %ld on the wrong side, worst %.2g cm\n", walker.flights,
           walker.crossings, walker.wrong, walker.worst);
    assert_true(walker.crossings > flights / 4);
    assert_int_equal(walker.wrong, 0);
    cml_mesh_surface_free(surface);
}

#ifndef FLIGHTS
#define FLIGHTS 200000
#endif

static void nothing_slips_through_a_rough_mesh(void **state)
{
    (void)state;
    check_walk(71, 0.1, CML_SEARCH_AUTO, FLIGHTS);
    check_walk(73, 0.1, CML_SEARCH_TREE, FLIGHTS);
}

static void nothing_slips_through_a_nearly_flat_mesh(void **state)
{
    (void)state;
    check_walk(72, 1e-3, CML_SEARCH_AUTO, FLIGHTS);
    check_walk(74, 1e-3, CML_SEARCH_TREE, FLIGHTS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_slips_through_a_rough_mesh),
        cmocka_unit_test(nothing_slips_through_a_nearly_flat_mesh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
