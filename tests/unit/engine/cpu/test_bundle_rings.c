/* Compares the vector search for rings (many packets at a time) with the kernels' search (one packet), bit
 * for bit.
 * The cases are those in which the two could differ: a root that takes an iterative search, a root at the
 * end of the path, and a direction that the facet overrules. Such cases are too rare to show in whole
 * tallies. The file is compiled once for each level of the processor. SPDX-License-Identifier: MIT */
#include "lib/cone_oracle.h"
#include "engine/cpu/engine_cpu.h"

#pragma GCC diagnostic ignored "-Wunused-function" /* vector functions of one lane, unused here */
#include "engine/cpu/bundle_curved_hits_inl.h"

static const double turn = 6.283185307179586;

static int same(real a, real b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

static int same_vector(struct cml_vec a, real x, real y, real z)
{
    return same(a.x, x) && same(a.y, y) && same(a.z, z);
}

/* Returns the direction (x, y, z) with a length of 1 but for rounding. */
static struct cml_vec unit(double x, double y, double z)
{
    const double size = sqrt(x * x + y * y + z * z);
    return (struct cml_vec){(real)(x / size), (real)(y / size), (real)(z / size)};
}

static double small_number(struct dice *dice)
{
    const double size = exp(dice_between(dice, log(1e-8), 0));
    return dice_below(dice, 2) ? size : -size;
}

/* ---- packets on their way to rings ---- */

struct made_up {
    struct field field;
    struct cml_surface surface;
    struct cml_world world; /* world with one boundary */
};

/* Makes a random field of rings and its world. Half of the fields have few and wide rings, so that packets
 * meet the tip often. */
static void make_up(struct dice *dice, struct made_up *m)
{
    static const double r[] = {0, 1, 3};
    double z[3];
    for (int i = 0; i < COUNT(z); i++) z[i] = small_number(dice);
    struct field *field = &m->field;
    *field = dice_below(dice, 2) ? field_random(dice, dice_below(dice, 3) ? 10 : 0.5) : field_of(3, r, z);
    m->surface = (struct cml_surface){
        .kind = CML_SURFACE_CONE, .num_rings = field->n, .parts_per_cm = field->parts_per_cm};
    m->surface.lowest = (real)-field->deepest;
    m->surface.highest = (real)field->deepest;
    m->world = (struct cml_world){.surfaces = &m->surface,
                                  .ring_r = field->r,
                                  .ring_z = field->z,
                                  .ring_slope = field->slope,
                                  .ring_start = field->start,
                                  .setup = {.stream = dice->stream, .x0 = (real)0.3, .y0 = (real)-0.1}};
}

struct path {
    struct cml_vec p, u; /* p: in the boundary's frame, from the beam's axis */
    real t_max;
    int on_ring; /* ring that the packet stands on, or -1 */
};

static int field_hit(const struct made_up *m, const struct path *path, real side, struct cml_hit *hit)
{
    const struct cml_interval s = {1, 0, path->t_max};
    return cml_intersect_field(&m->world, 0, path->p, path->u, side, s, path->on_ring, 0, hit);
}

/* Draws a direction to a place of ring i at radius r > 0 and azimuth 0. The direction is arbitrary, or
 * almost in the cone, or almost along the cone's line to the tip. */
static void direction_to_ring(struct dice *dice, const struct field *field, int i, double u[3])
{
    const int kind = dice_below(dice, 3);
    dice_direction(dice, u);
    if (kind == 0) return;
    if (kind == 2) u[1] = small_number(dice);
    u[2] = (double)field->slope[i] * u[0] + small_number(dice);
}

/* Draws a path to a place on a ring. It starts some way before the ring, or on the ring. */
static struct path path_to_ring(struct dice *dice, const struct made_up *m)
{
    const struct field *field = &m->field;
    const int i = dice_below(dice, field->n), stands = dice_below(dice, 8) == 0,
              near_tip = dice_below(dice, 2);
    const double inner = (double)field->r[i], outer = i + 1 < field->n ? (double)field->r[i + 1] : 2 * inner;
    const double part = near_tip ? fabs(small_number(dice)) : dice_uniform(dice);
    const double r = inner + (outer - inner) * part, azimuth = dice_between(dice, 0, turn);
    const double scale = dice_below(dice, 2) ? 1 : outer - inner;
    const double back = stands ? 0 : scale * dice_between(dice, 0, 3);
    const double c = cos(azimuth), s = sin(azimuth);
    double v[3];
    direction_to_ring(dice, field, i, v);
    const struct cml_vec u = unit(c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]);
    const struct path path = {
        {(real)(r * c - back * (double)u.x - (double)m->world.setup.x0),
         (real)(r * s - back * (double)u.y - (double)m->world.setup.y0),
         (real)((double)field->z[i] + (double)field->slope[i] * (r - inner) - back * (double)u.z)},
        u,
        CML_INFINITY,
        stands ? i : -1};
    return path;
}

static real side_of(const struct made_up *m, const struct path *path)
{
    const struct ray ray = ray_of(cml_from_scene_axis(&m->world, path->p), path->u, 1);
    return ray_height(&m->field, &ray, 0) > 0 ? (real)1 : (real)-1;
}

/* Draws the length of a path: infinite, or up to its first root, or some roundings shorter or longer than
 * that. */
static void end_near_root(struct dice *dice, const struct made_up *m, real side, struct path *path)
{
    struct cml_hit hit;
    if (dice_below(dice, 2)) return;
    if (!field_hit(m, path, side, &hit)) return;
    if (hit.t > 0) path->t_max = hit.t;
    for (int n = dice_below(dice, 4); n > 0; n--) path->t_max = nextafterf(path->t_max, CML_INFINITY);
}

/* Does for one path what cml_march_lane and cml_add_hit do for a lane, from the path's start. Returns 0 if
 * the path meets no ring. */
static int march(const struct made_up *m, const struct path *path, real side, struct cml_hits *h)
{
    const struct cml_rings rings = cml_rings_of(&m->world, 0);
    const int k = h->count;
    struct cml_cone_march march =
        cml_cone_begin(rings, cml_from_scene_axis(&m->world, path->p), path->u, side, 0, path->on_ring);
    const enum cml_cone_verdict verdict = cml_cone_go(rings, &march, path->t_max, 1, &h->t[k]);
    if (verdict == CML_CONE_MISSED) return 0;
    h->count++;
    h->known[k] = verdict == CML_CONE_HIT;
    h->primitive[k] = march.ring;
    h->x[k] = path->p.x;
    h->y[k] = path->p.y;
    h->z[k] = path->p.z;
    h->ux[k] = march.ray.u.x;
    h->uy[k] = march.ray.u.y;
    h->uz[k] = march.ray.u.z;
    h->ring_r[k] = rings.r[march.ring];
    h->ring_z[k] = rings.z[march.ring];
    h->ring_end[k] = cml_ring_end(rings, march.ring);
    h->slope[k] = rings.slope[march.ring];
    h->t0[k] = march.t0;
    h->t1[k] = march.t1;
    h->t_max[k] = path->t_max;
    return 1;
}

struct seen {
    /* counts of packets; the last three are of doubtful ones, about which the engine asks the kernels */
    long settled, known, missed, at_once, searched, at_end;
};

/* Compares the vector answer for packet k with the kernels' answer. Doubtful packets are only counted,
 * because the engine asks the kernels about each of them again. */
static void compare_settled(const struct made_up *m, const struct path *path, real side,
                            const struct cml_hits *h, int k, struct seen *seen)
{
    struct cml_hit hit = {0};
    const int found = field_hit(m, path, side, &hit);
    if (h->doubtful[k]) {
        const struct cml_vec q = cml_from_scene_axis(&m->world, hit.point);
        assert_true(!h->known[k] ||
                    (q.x == 0 && q.y == 0)); /* a root known at once is doubtful at the tip only */
        seen->at_once += found && !(hit.t > 0);
        seen->searched += found && hit.t > 0;
        seen->at_end += !found;
        return;
    }
    seen->known += h->known[k];
    seen->settled += !h->known[k];
    if (!found || !same(hit.t, h->t[k]) || hit.primitive != h->primitive[k] ||
        !same_vector(hit.point, h->x[k], h->y[k], h->z[k]) ||
        !same_vector(hit.facet, h->normal_x[k], h->normal_y[k], h->normal_z[k]))
        fail_msg("p (%.9g %.9g %.9g) u (%.9g %.9g %.9g) t_max %.9g: t %.9g ring %d; by itself %d, t %.9g "
                 "ring %d",
                 (double)path->p.x, (double)path->p.y, (double)path->p.z, (double)path->u.x,
                 (double)path->u.y, (double)path->u.z, (double)path->t_max, (double)h->t[k], h->primitive[k],
                 found, (double)hit.t, hit.primitive);
}

/* Sends as many packets as a bundle has lanes from one side to the rings and compares all of them. */
static void meet_rings(struct dice *dice, const struct made_up *m, real side, struct seen *seen)
{
    static struct cml_hits h;
    static struct path path[CML_LANES];
    memset(&h, 0xff, sizeof h); /* members behind the count may hold any bytes */
    h.count = 0;
    for (int n = 0; n < 3 * CML_LANES && h.count < CML_LANES; n++) {
        struct cml_hit hit;
        struct path *next = &path[h.count];
        *next = path_to_ring(dice, m);
        if (next->on_ring < 0 && side_of(m, next) != side) continue;
        end_near_root(dice, m, side, next);
        if (march(m, next, side, &h)) continue;
        seen->missed++;
        assert_false(field_hit(m, next, side, &hit));
    }
    cml_hits_refine_rings(&m->world, side, &h);
    for (int k = 0; k < h.count; k++) compare_settled(m, &path[k], side, &h, k, seen);
}

static void packets_meet_rings_where_each_does_by_itself(void **state)
{
    (void)state;
    struct dice dice = dice_new(71);
    struct seen seen = {0};
    for (int n = 0; n < 3000; n++) {
        static struct made_up m;
        make_up(&dice, &m);
        meet_rings(&dice, &m, 1, &seen);
        meet_rings(&dice, &m, -1, &seen);
    }
    printf("%ld roots settled, %ld known, %ld misses; doubtful: %ld hits at once, %ld later, %ld misses\n",
           seen.settled, seen.known, seen.missed, seen.at_once, seen.searched, seen.at_end);
    assert_true(seen.settled > 100000 && seen.known > 10000 && seen.missed > 10000);
    assert_true(seen.at_once > 100 && seen.searched > 100 && seen.at_end > 100);
    assert_true(seen.at_once + seen.searched + seen.at_end < seen.settled / 4);
}

/* ---- packets at rings ---- */

static const double indices[][2] = {{1, 1.4}, {1.4, 1}, {1.33, 1.5}, {1.5, 1.33}, {1.4, 1.4001}, {2.5, 1}};

/* Draws a direction at a ring with normal n: at any angle, almost in the ring's plane, leading away from
 * the ring, or near the critical angle. */
static struct cml_vec direction_at(struct dice *dice, struct cml_vec up, real side, const double n[2])
{
    const double critical = n[1] < n[0] ? sqrt(1 - n[1] * n[1] / (n[0] * n[0])) : 0;
    const double any = dice_between(dice, -0.2, 1), small = small_number(dice);
    const double cosines[] = {any, small, critical * (1 + 0.1 * small)};
    const double size = sqrt((double)cml_dot(up, up));
    const double c = fmin(cosines[dice_below(dice, 3)] / size, 1), against = c * (double)side;
    const double e[3] = {(double)up.x / size, (double)up.y / size, (double)up.z / size};
    double v[3];
    dice_direction(dice, v);
    const double along = v[0] * e[0] + v[1] * e[1] + v[2] * e[2];
    const double across = sqrt((1 - c * c) / (1 - along * along)), more = against - across * along;
    return unit(across * v[0] + more * e[0], across * v[1] + more * e[1], across * v[2] + more * e[2]);
}

/* Draws a normal of a random ring. Some normals are too long, by far more than rounding makes them.
 * Otherwise a refracted direction that leaves on the wrong side would be too rare to test. */
static struct cml_vec normal_of_any(struct dice *dice)
{
    const double slope = dice_below(dice, 3) ? 10 * small_number(dice) : 0;
    const double azimuth = dice_between(dice, 0, turn);
    const real size = dice_below(dice, 4) ? (real)1 : (real)1.01;
    const struct cml_vec up =
        cml_cone_normal_of_slope((real)slope, (real)cos(azimuth), (real)sin(azimuth), 1);
    return (struct cml_vec){size * up.x, size * up.y, size * up.z};
}

static void place_at_ring(struct dice *dice, real side, const double n[2], struct cml_hits *h)
{
    const int k = h->count++;
    const struct cml_vec up = normal_of_any(dice);
    const struct cml_vec u = direction_at(dice, up, side, n);
    h->normal_x[k] = up.x;
    h->normal_y[k] = up.y;
    h->normal_z[k] = up.z;
    h->ux[k] = u.x;
    h->uy[k] = u.y;
    h->uz[k] = u.z;
    h->index_low[k] = dice_word(dice);
    h->index_high[k] = dice_word(dice);
    h->crossings[k] = dice_word(dice) >> 8;
    h->doubtful[k] = dice_below(dice, 16) == 0;
}

struct turned {
    long through, mirrored, goes_on, through_overruled, mirrored_overruled;
};

/* Compares reflected and refracted directions of the vector code with the kernels'. Returns how many
 * directions the facet has overruled. */
static int compare_turned(const struct cml_world *world, real side, const double n[2],
                          const struct cml_hits *before, const struct cml_hits *after, int k,
                          struct turned *sum)
{
    const struct cml_vec up = {before->normal_x[k], before->normal_y[k], before->normal_z[k]},
                         u = {before->ux[k], before->uy[k], before->uz[k]};
    const struct cml_hit hit = {.normal = up, .facet = up};
    struct cml_packet packet = {.index = (cml_u64)before->index_high[k] << 32 | before->index_low[k],
                                .u = u,
                                .crossings = before->crossings[k]};
    const int through = cml_reflect_or_refract(world, &packet, &hit, side, (real)n[0], (real)n[1]);
    const int goes_on = !through && same_vector(u, packet.u.x, packet.u.y, packet.u.z);
    const int overruled = (int)packet.shading_overruled;
    if (through != after->through[k] || !same_vector(packet.u, after->ux[k], after->uy[k], after->uz[k]))
        fail_msg("u (%.9g %.9g %.9g) up (%.9g %.9g %.9g) side %g: %d (%.9g %.9g %.9g); by itself %d (%.9g "
                 "%.9g %.9g)",
                 (double)u.x, (double)u.y, (double)u.z, (double)up.x, (double)up.y, (double)up.z,
                 (double)side, after->through[k], (double)after->ux[k], (double)after->uy[k],
                 (double)after->uz[k], through, (double)packet.u.x, (double)packet.u.y, (double)packet.u.z);
    sum->through += through;
    sum->mirrored += !through && !goes_on;
    sum->goes_on += goes_on && overruled;
    sum->through_overruled += through && overruled;
    sum->mirrored_overruled += !through && !goes_on && overruled;
    return before->doubtful[k] ? 0 : overruled;
}

static void packets_turn_at_rings_as_each_does_by_itself(void **state)
{
    (void)state;
    static struct cml_hits h, before;
    struct dice dice = dice_new(72);
    struct turned sum = {0};
    const struct cml_surface surface = {.kind = CML_SURFACE_CONE};
    const struct cml_world world = {.surfaces = &surface, .setup = {.stream = dice.stream}};
    for (int i = 0; i < 6000; i++) {
        const double *n = indices[i % COUNT(indices)];
        const real side = dice_below(&dice, 2) ? (real)1 : (real)-1;
        const int count = 1 + dice_below(&dice, CML_LANES);
        int overruled = 0;
        h.count = 0;
        while (h.count < count) place_at_ring(&dice, side, n, &h);
        before = h;
        const int counted = cml_hits_reflect_or_refract(&world.setup, side, (real)n[0], (real)n[1], &h);
        for (int k = 0; k < count; k++) overruled += compare_turned(&world, side, n, &before, &h, k, &sum);
        assert_int_equal(counted, overruled);
    }
    printf("%ld through, %ld mirrored, %ld go on; overruled to the same: %ld through, %ld mirrored\n",
           sum.through, sum.mirrored, sum.goes_on, sum.through_overruled, sum.mirrored_overruled);
    assert_true(sum.through > 10000 && sum.mirrored > 10000 && sum.goes_on > 1000);
    assert_true(sum.through_overruled > 10 && sum.mirrored_overruled > 10);
}

#ifndef RINGS_LEVEL
#define RINGS_LEVEL "baseline"
#endif

static int machine_can_run(const char *name)
{
    struct cml_cpu_level levels[CML_CPU_LEVELS];
    for (int i = cml_cpu_levels(levels); i-- > 0;)
        if (strcmp(levels[i].name, name) == 0) return 1;
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packets_meet_rings_where_each_does_by_itself),
        cmocka_unit_test(packets_turn_at_rings_as_each_does_by_itself),
    };
    if (!machine_can_run(RINGS_LEVEL)) return 77;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
