/* Random rays and walks against random heightfields, compiled once in float and once in double. The oracle
 * of cone_oracle.h judges them. The oracle takes the same rounded numbers as the kernel, so a difference
 * is a fault of the kernel. SPDX-License-Identifier: MIT */
#include "lib/cone_oracle.h"
#include "walk.h"

static const double eps = (double)CML_EPSILON;

/* Range of distances in which the first crossing may lie, given the rounding of heights. */
struct verdict {
    double exact, early, late;
};

static struct verdict judge(const struct field *field, const struct ray *ray, double t_max, double rounding)
{
    long double station[4 * MAX_RINGS];
    const int n = ray_stations(field, ray, ray_end(field, ray, t_max), station);
    const struct verdict verdict = {(double)ray_first_below(field, ray, 0, station, n),
                                    (double)ray_first_below(field, ray, rounding, station, n),
                                    (double)ray_first_below(field, ray, -rounding, station, n)};
    return verdict;
}

static struct cml_vec random_direction(struct dice *dice, struct cml_vec p)
{
    double u[3];
    dice_direction(dice, u);
    const int kind = dice_below(dice, 8);
    if (kind == 0) u[2] *= 1e-3; /* a grazing ray */
    if (kind == 1) u[0] = u[1] = 0;
    if (kind == 2) u[2] = 0;
    if (kind == 3) { /* a ray through the axis */
        u[0] = -(double)p.x;
        u[1] = -(double)p.y;
    }
    if (kind == 4) {
        u[0] *= 1e-5;
        u[1] *= 1e-5;
    }
    const double length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    const struct cml_vec v = {(real)(u[0] / length), (real)(u[1] / length), (real)(u[2] / length)};
    return v;
}

static struct cml_vec random_point(struct dice *dice, const struct field *field)
{
    const double reach = 1.3 * (double)field->r[field->n - 1] * sqrt(dice_uniform(dice));
    const double phi = dice_between(dice, 0, 6.283185307179586);
    const double height = dice_below(dice, 2) ? 1 : 3 * field->deepest;
    const struct cml_vec p = {(real)(reach * cos(phi)), (real)(reach * sin(phi)),
                              (real)(field_depth(field, reach) + dice_between(dice, -0.5, 0.5) * height)};
    return p;
}

struct tally_of_rays {
    long hits, misses, differ; /* differ: one of the two found a hit, within rounding of the surface */
    double worst; /* largest error of a distance, relative to the distance, without grazing crossings */
};

/* Returns a direction from p to a point on a ring's edge, where two cones meet. */
static struct cml_vec towards_an_edge(struct dice *dice, const struct field *field, struct cml_vec p)
{
    const int i = dice_below(dice, field->n);
    const double phi = dice_between(dice, 0, 6.283185307179586), r = (double)field->r[i];
    const double x = r * cos(phi) - (double)p.x, y = r * sin(phi) - (double)p.y,
                 z = (double)field->z[i] - (double)p.z, length = sqrt(x * x + y * y + z * z);
    const struct cml_vec u = {(real)(x / length), (real)(y / length), (real)(z / length)};
    return u;
}

static void one_ray(struct dice *dice, const struct field *field, struct tally_of_rays *sum)
{
    const struct cml_vec p = random_point(dice, field);
    const struct cml_vec u =
        dice_below(dice, 3) ? random_direction(dice, p) : towards_an_edge(dice, field, p);
    struct ray ray = ray_of(p, u, 1);
    ray.side = ray_height(field, &ray, 0) > 0 ? 1 : -1;
    const double t_max = dice_below(dice, 3) ? dice_between(dice, 0, 8) : INFINITY;
    real t = -1;
    int ring = -1;
    const int hit = cml_cone_hit(rings_of(field), p, u, (real)ray.side, 0, (real)t_max, -1, &t, &ring);
    const double reach = hit ? (double)t : fmin(t_max, 4 * (double)field->r[field->n - 1]);
    const double rounding = 8 * ray_rounding(field, &ray, reach);
    const struct verdict v = judge(field, &ray, (double)(real)t_max, rounding);
    const double blur = 8 * eps * (reach + field->deepest);
    const bool right = hit ? (double)t >= v.early - blur && (double)t <= v.late + blur : v.late == INFINITY;
    if (!right)
        fail_msg(
            "p (%.17g %.17g %.17g) u (%.17g %.17g %.17g) side %g t_max %g, %d rings: hit %d t %.17g, oracle "
            "%.17g in [%.17g, %.17g]",
            (double)p.x, (double)p.y, (double)p.z, (double)u.x, (double)u.y, (double)u.z, ray.side, t_max,
            field->n, hit, (double)t, v.exact, v.early, v.late);
    if (hit)
        sum->hits++;
    else
        sum->misses++;
    if (hit != (v.exact < INFINITY)) {
        sum->differ++;
    } else if (hit && v.late - v.early < 64 * rounding) {
        assert_true(ring >= 0 && ring < field->n);
        sum->worst = fmax(sum->worst, fabs((double)t - v.exact) / fmax(v.exact, 1));
    }
}

static void random_rays_hit_where_the_oracle_says(void **state)
{
    (void)state;
    struct dice dice = dice_new(51);
    struct tally_of_rays sum = {0, 0, 0, 0};
    for (int n = 0; n < repeats(300); n++) {
        const struct field field = field_random(&dice, n % 3 ? 10 : 0.5);
        for (int k = 0; k < 100; k++) one_ray(&dice, &field, &sum);
    }
    printf("%ld hits, %ld misses, %ld that only rounding decides, distance error %.2g\n", sum.hits,
           sum.misses, sum.differ, sum.worst);
    assert_true(sum.hits > repeats(10000) && sum.misses > repeats(5000));
    assert_true(sum.differ <= 100);
    assert_true(sum.worst < (sizeof(real) == 4 ? 1e-2 : 1e-9));
}

static struct cml_surface surface_of(const struct field *field)
{
    struct cml_surface surface = {
        .kind = CML_SURFACE_CONE, .num_rings = field->n, .parts_per_cm = field->parts_per_cm};
    surface.lowest = surface.highest = field->z[0];
    for (int i = 1; i < field->n; i++) {
        if (field->z[i] < surface.lowest) surface.lowest = field->z[i];
        if (field->z[i] > surface.highest) surface.highest = field->z[i];
    }
    return surface;
}

/* Returns a point near or far, mostly outside the depths of the field. */
static struct cml_vec point_outside(struct dice *dice, const struct field *field)
{
    struct cml_vec p = random_point(dice, field);
    const double away = exp(dice_between(dice, log(1e-3), log(30)));
    if (dice_below(dice, 4)) p.z = (real)((field->deepest + away) * (dice_below(dice, 2) ? 1 : -1));
    return p;
}

/* Returns a distance shortly before the ray enters the depths of the field; 0 if the ray does not come
 * from outside. */
static real depths_entry(const struct cml_surface *surface, real z, real uz, real side)
{
    const real t = ((side > 0 ? surface->highest : surface->lowest) - z) / uz;
    return side * uz < 0 && t > 0 ? (real)0.9990234375 * t : (real)0;
}

/* A search that begins where the ray enters the field's depths finds the same crossing as one from the
 * ray's start. */
static void rays_from_outside_hit_what_the_whole_march_hits(void **state)
{
    (void)state;
    struct dice dice = dice_new(53);
    long hits = 0, clipped = 0;
    for (int n = 0; n < repeats(1000); n++) {
        const struct field field = field_random(&dice, n % 3 ? 10 : 0.5);
        const struct cml_surface surface = surface_of(&field);
        for (int k = 0; k < 2000; k++) {
            const struct cml_vec p = point_outside(&dice, &field);
            const struct cml_vec u =
                dice_below(&dice, 3) ? random_direction(&dice, p) : towards_an_edge(&dice, &field, p);
            const struct ray ray = ray_of(p, u, 1);
            const real side = ray_height(&field, &ray, 0) > 0 ? 1 : -1;
            const real t_max = dice_below(&dice, 3) ? (real)dice_between(&dice, 0, 40) : CML_INFINITY;
            const real t_min = depths_entry(&surface, p.z, u.z, side);
            real t[2] = {0, 0};
            int ring[2];
            const int whole = cml_cone_hit(rings_of(&field), p, u, side, 0, t_max, -1, &t[0], &ring[0]);
            const int part = cml_cone_hit(rings_of(&field), p, u, side, t_min, t_max, -1, &t[1], &ring[1]);
            if (whole != part || (whole && (t[0] != t[1] || ring[0] != ring[1])))
                fail_msg("p (%.9g %.9g %.9g) u (%.9g %.9g %.9g) from %.9g: %d %.9g ring %d, whole march %d "
                         "%.9g ring "
                         "%d",
                         (double)p.x, (double)p.y, (double)p.z, (double)u.x, (double)u.y, (double)u.z,
                         (double)t_min, part, (double)t[1], ring[1], whole, (double)t[0], ring[0]);
            hits += whole;
            clipped += t_min > 0;
        }
    }
    printf("%ld hits, %ld rays clipped\n", hits, clipped);
    assert_true(hits > repeats(500000) && clipped > repeats(500000));
}

/* Returns a point before a ring, and a direction that meets the ring's cone at a small angle. */
static struct cml_vec graze(struct dice *dice, const struct field *field, struct cml_vec *u)
{
    const int i = dice_below(dice, field->n - 1);
    const double r0 = (double)field->r[i], dr = (double)field->r[i + 1] - r0;
    const double m = (double)field->slope[i], s = dice_uniform(dice), along = dice_between(dice, -1, 1);
    const double turn = exp(dice_between(dice, log(1e-7), 0)), angle = exp(dice_between(dice, log(1e-7), -3));
    double v[3] = {along, turn, m * along - angle}, size = 0; /* components outwards, around the axis, down */
    for (int k = 0; k < 3; k++) size = hypot(size, v[k]);
    for (int k = 0; k < 3; k++) v[k] /= size;
    const double flown = dr * dice_uniform(dice), r = r0 + s * dr;
    *u = (struct cml_vec){(real)v[0], (real)v[1], (real)v[2]};
    return (struct cml_vec){(real)(r - flown * v[0]), (real)(-flown * v[1]),
                            (real)((double)field->z[i] + m * s * dr - flown * v[2])};
}

/* Grazing rays are met on the surface, although the quadratic of a cone determines the place of crossing
 * poorly. */
static void grazing_rays_hit_the_surface_where_it_is(void **state)
{
    (void)state;
    struct dice dice = dice_new(55);
    long hits = 0;
    double worst = 0;
    for (int n = 0; n < repeats(2000); n++) {
        const struct field field = field_random(&dice, 2);
        for (int k = 0; k < 1000; k++) {
            struct cml_vec u;
            const struct cml_vec p = graze(&dice, &field, &u);
            const struct ray ray = ray_of(p, u, 1);
            const real side = ray_height(&field, &ray, 0) > 0 ? 1 : -1;
            real t;
            int ring;
            if (!cml_cone_hit(rings_of(&field), p, u, side, 0, CML_INFINITY, -1, &t, &ring)) continue;
            hits++;
            worst = fmax(worst,
                         fabs((double)ray_height(&field, &ray, t)) / ray_rounding(&field, &ray, (double)t));
        }
    }
    printf("%ld hits, off the surface by %.2g roundings\n", hits, worst);
    assert_true(hits > repeats(500000));
    assert_true(worst < (sizeof(real) == 4 ? 8 : 1024)); /* double has digits to spare near the axis */
}

/* In a hollow a packet may be reflected many times by the same ring. */
static void a_packet_slides_along_a_hollow_on_its_surface(void **state)
{
    (void)state;
    struct dice dice = dice_new(56);
    static const double r[] = {0, 1, 2}, z[] = {1, -0.5, -0.5};
    const struct field field = field_of(3, r, z);
    double sum = 0;
    long hits = 0;
    for (int n = 0; n < repeats(1000); n++) {
        const double s = dice_between(&dice, 0.3, 0.9), tilt = dice_between(&dice, 0, 0.03);
        struct cml_vec p = {(real)s, 0, (real)(1 - 1.5 * s)},
                       u = {(real)tilt, (real)sqrt(1 - tilt * tilt), 0};
        real t;
        int ring = 0;
        for (int k = 0; k < 300; k++) {
            if (!cml_cone_hit(rings_of(&field), p, u, -1, 0, CML_INFINITY, ring, &t, &ring)) break;
            p = cml_along(p, t, u);
            const struct cml_vec facet = cml_cone_facet(rings_of(&field), ring, p.x, p.y);
            u = cml_along(u, -2 * cml_dot(u, facet), facet);
            const struct ray ray = ray_of(p, u, 1);
            sum += fabs((double)ray_height(&field, &ray, 0)) / ray_rounding(&field, &ray, 0);
            hits++;
        }
    }
    printf("%ld reflections, off the surface by %.2g roundings in the mean\n", hits, sum / (double)hits);
    assert_true(hits > repeats(50000));
    assert_true(sum < 0.15 * (double)hits);
}

/* Does what cml_cone_hit does from t = 0, but one span at a time. Returns the number of spans. */
static int march_alone(struct cml_rings rings, struct cml_vec p, struct cml_vec u, real side, real t_max,
                       int *hit, real *t, int *ring)
{
    struct cml_cone_march march = cml_cone_begin(rings, p, u, side, 0, -1);
    for (int spans = 1;; spans++) {
        int next;
        const real exit = cml_ring_exit(rings, &march.ray, march.ring, march.inwards, &next);
        if (next > march.ring) march.inwards = 0;
        if (!(exit < t_max)) next = -1;
        const real t1 = next < 0 ? t_max : (exit > march.t0 ? exit : march.t0);
        const real end = cml_ring_height(rings, &march.ray, march.ring, next, t1);
        *ring = march.ring;
        *hit = cml_ring_span(rings, &march.ray, march.ring, end, 0, march.t0, t1, t) && *t < t_max;
        if (*hit || next < 0) return spans;
        march.ring = next;
        march.t0 = t1;
    }
}

/* Returns a field of many rings of equal width on a slope. Some rings lie deeper, by rounding or by much. */
static struct field field_of_many(struct dice *dice)
{
    struct field field = {.n = MAX_RINGS};
    const double slope = dice_between(dice, -0.2, 0.2), rough = dice_below(dice, 2) ? 1e-3 : 1e-6;
    for (int i = 0; i < field.n; i++) {
        field.r[i] = (real)(0.02 * i);
        field.z[i] = (real)(0.02 * slope * i + rough * dice_between(dice, -1, 1));
    }
    field_finish(&field);
    return field;
}

/* A march over many rings looks at several spans together and finds the same crossing as span by span. */
static void a_march_over_many_rings_misses_none(void **state)
{
    (void)state;
    struct dice dice = dice_new(57);
    long hits = 0, far = 0;
    for (int n = 0; n < repeats(100000); n++) {
        const struct field field = n % 2 ? field_of_many(&dice) : field_random(&dice, 0.1);
        const struct cml_vec p = random_point(&dice, &field), u = towards_an_edge(&dice, &field, p);
        const struct ray ray = ray_of(p, u, 1);
        const real side = ray_height(&field, &ray, 0) > 0 ? 1 : -1, t_max = (real)dice_between(&dice, 0, 4);
        real t[2] = {0, 0};
        int ring[2], alone;
        const int spans = march_alone(rings_of(&field), p, u, side, t_max, &alone, &t[0], &ring[0]);
        const int hit = cml_cone_hit(rings_of(&field), p, u, side, 0, t_max, -1, &t[1], &ring[1]);
        if (field.slope[ring[0]] == 0) continue; /* level rings are met by other code */
        assert_int_equal(hit, alone);
        assert_true(!hit || (t[0] == t[1] && ring[0] == ring[1]));
        hits += hit;
        far += spans > 24;
    }
    printf("%ld hits, %ld marches over more than 24 rings\n", hits, far);
    assert_true(hits > repeats(30000) && far > repeats(10000));
}

/* ---- walks ---- */

struct walker {
    const struct field *field;
    struct cml_surface surface;
    struct cml_world world; /* world with one boundary */
    struct cml_packet packet;
    double side;
    long crossings, flights;
    double worst; /* deepest place on the wrong side, in roundings of the height */
};

static void place(struct dice *dice, struct walker *walker)
{
    struct cml_packet *packet = &walker->packet;
    packet->p = random_point(dice, walker->field);
    packet->u = random_direction(dice, packet->p);
    packet->on_primitive = -1;
    const struct ray ray = ray_of(packet->p, packet->u, 1);
    walker->side = ray_height(walker->field, &ray, 0) > 0 ? 1 : -1;
}

static void enter(struct dice *dice, struct walker *walker, const struct field *field)
{
    walker->field = field;
    walker->surface = surface_of(field);
    walker->world.surfaces = &walker->surface;
    walker->world.ring_r = field->r;
    walker->world.ring_z = field->z;
    walker->world.ring_slope = field->slope;
    walker->world.ring_start = field->start;
    walker->packet.index++;
    place(dice, walker);
}

static void look(struct walker *walker, double flown)
{
    const struct cml_vec p = walker->packet.p;
    const struct ray ray = ray_of(p, walker->packet.u, walker->side);
    const double wrong =
        (double)-ray_height(walker->field, &ray, 0) / ray_rounding(walker->field, &ray, flown);
    walker->worst = fmax(walker->worst, wrong);
    if (wrong > 64)
        fail_msg("on the wrong side by %g roundings after %ld flights, p (%.9g %.9g %.9g)", wrong,
                 walker->flights, (double)p.x, (double)p.y, (double)p.z);
}

/* Checks that the packet heads through the surface that it meets. A packet that has left a ring and meets
 * it again at once would head the other way. */
static void look_at_hit(const struct walker *walker, const struct cml_hit *hit)
{
    const double ahead = walker->side * (double)cml_dot(walker->packet.u, hit->facet);
    if (!(ahead > -1e-3))
        fail_msg("met the surface from behind (%g) after %ld flights", ahead, walker->flights);
}

/* Draws a new direction, mostly one back towards the surface. */
static void scatter(struct dice *dice, struct walker *walker)
{
    struct cml_vec u = random_direction(dice, walker->packet.p);
    if (dice_below(dice, 8) && walker->side * (double)u.z > 0) u.z = -u.z;
    walker->packet.u = u;
}

/* Crosses the surface by the rules of the walk, with equal indices or one of three other pairs. */
static void cross(struct dice *dice, struct walker *walker, const struct cml_hit *hit)
{
    static const double index[][2] = {{1, 1}, {1, 1.4}, {1.4, 1}, {1, 3}};
    const double *n = index[dice_below(dice, COUNT(index))];
    const int transmitted =
        n[0] == n[1] || cml_reflect_or_refract(&walker->world, &walker->packet, hit, (real)walker->side,
                                               (real)n[0], (real)n[1]);
    if (transmitted) walker->side = -walker->side;
    walker->crossings++;
}

static void fly(struct dice *dice, struct walker *walker)
{
    const struct field *field = walker->field;
    struct cml_packet *packet = &walker->packet;
    const double free_path = -log(dice_uniform(dice)) * (dice_below(dice, 2) ? 10 : 0.2);
    struct cml_hit hit = {.t = (real)free_path};
    walker->flights++;
    const struct cml_interval s = {1, 0, hit.t};
    const int found = cml_intersect_field(&walker->world, 0, packet->p, packet->u, (real)walker->side, s,
                                          packet->on_primitive, 0, &hit);
    packet->p = found ? hit.point : cml_along(packet->p, hit.t, packet->u);
    packet->on_primitive = found ? hit.primitive : -1;
    look(walker, (double)hit.t);
    if (found) look_at_hit(walker, &hit);
    if (found)
        cross(dice, walker, &hit);
    else
        scatter(dice, walker);
    const double r = hypot((double)packet->p.x, (double)packet->p.y);
    if (r > 1.5 * (double)field->r[field->n - 1] ||
        fabs((double)packet->p.z - (double)field_depth(field, r)) > 2 * field->deepest)
        place(dice, walker);
}

/* A walk changes its side at each crossing and never computes it from its position. If a crossing were
 * missed, the walk would go deep into the wrong side, and `worst` would be large. */
#ifndef FIELDS
#define FIELDS 25
#endif
static void a_walk_of_a_million_flights_never_slips_through(void **state)
{
    (void)state;
    struct dice dice = dice_new(52);
    struct walker walker = {.worst = 0};
    for (int n = 0; n < FIELDS; n++) {
        const struct field field = field_random(&dice, n % 3 ? 5 : 0.5);
        enter(&dice, &walker, &field);
        for (int k = 0; k < repeats(40000); k++) fly(&dice, &walker);
    }
    printf("%ld flights, %ld crossings, wrong side by %.2g roundings\n", walker.flights, walker.crossings,
           walker.worst);
    assert_true(walker.crossings > (long)repeats(10000) * FIELDS);
}

/* Returns grooves with walls of slope 1000 and bottoms at z = 0. */
static struct field grooves(void)
{
    struct field field = {.n = 41};
    for (int i = 0; i < field.n; i++) {
        field.r[i] = (real)(1e-4 * i);
        field.z[i] = (real)(i % 2 ? -0.1 : 0);
    }
    field_finish(&field);
    return field;
}

/* A packet dropped on the bottom of a groove is mirrored from wall to wall until it comes up again. On
 * such steep walls its radius determines its depth only to 1000 roundings. */
static void a_packet_does_not_sink_between_walls(void **state)
{
    (void)state;
    struct dice dice = dice_new(55);
    const struct field field = grooves();
    struct walker walker = {.worst = 0};
    enter(&dice, &walker, &field);
    long reflections = 0;
    for (int n = 0; n < repeats(2000); n++) {
        const double r = (double)field.r[2 + 2 * dice_below(&dice, 19)], phi = dice_between(&dice, 0, 6.28);
        const real ulps = (real)(dice_below(&dice, 5) - 2) * CML_EPSILON;
        struct cml_vec p = {(real)(r * cos(phi)) * (1 + ulps), (real)(r * sin(phi)), (real)-1};
        struct cml_vec u = {0, 0, 1};
        struct cml_hit hit = {.primitive = -1};
        for (int k = 0; k < 2000 && u.z > 0; k++, reflections++) {
            const struct cml_interval s = {1, 0, CML_INFINITY};
            if (!cml_intersect_field(&walker.world, 0, p, u, -1, s, hit.primitive, 0, &hit)) break;
            assert_true(hit.point.z <= 0);
            p = hit.point;
            u = cml_reflect(u, hit.facet);
        }
    }
    assert_true(reflections > repeats(100000));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_rays_hit_where_the_oracle_says),
        cmocka_unit_test(rays_from_outside_hit_what_the_whole_march_hits),
        cmocka_unit_test(grazing_rays_hit_the_surface_where_it_is),
        cmocka_unit_test(a_packet_slides_along_a_hollow_on_its_surface),
        cmocka_unit_test(a_march_over_many_rings_misses_none),
        cmocka_unit_test(a_packet_does_not_sink_between_walls),
        cmocka_unit_test(a_walk_of_a_million_flights_never_slips_through),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
