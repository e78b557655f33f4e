/* Tests of the horizon of rings, by the oracle for rays: packets that leave a ring at least as steeply
 * never meet the surface again. Of packets that leave a little less steeply from some place of the ring,
 * some do. SPDX-License-Identifier: MIT */
#include "lib/cone_oracle.h"
#include "surface/bounds/ring_horizon_inl.h"
#include "surface_hit.h"

#define FIELDS 300

struct horizons {
    real above[MAX_RINGS], below[MAX_RINGS];
};

static struct horizons horizons_of(const struct field *field)
{
    struct horizons horizons;
    int scratch[MAX_RINGS];
    cml_ring_horizons(field->r, field->z, field->n, -1, scratch, horizons.above);
    cml_ring_horizons(field->r, field->z, field->n, 1, scratch, horizons.below);
    return horizons;
}

/* Returns a ray from the surface at radius r that leaves to `side` with this slope. azimuth: of its
 * direction, from outwards. */
static struct ray ray_from(const struct field *field, double r, double azimuth, double slope, double side)
{
    const double across = 1 / sqrt(1 + slope * slope);
    const struct cml_vec p = {(real)r, 0, (real)field_depth(field, (long double)(real)r)};
    const struct cml_vec u = {(real)(across * cos(azimuth)), (real)(across * sin(azimuth)),
                              (real)(side * across * slope)};
    return ray_of(p, u, side);
}

/* Returns the least height of the ray above its side of the surface. */
static double least_height(const struct field *field, const struct ray *ray)
{
    long double station[3 * MAX_RINGS + 2], least = INFINITY;
    const int n = ray_stations(field, ray, ray_end(field, ray, INFINITY), station);
    for (int i = 0; i < n; i++) least = fminl(least, ray_height(field, ray, station[i]));
    return (double)least;
}

static double ring_width(const struct field *field, int i)
{
    return i + 1 < field->n ? (double)field->r[i + 1] - (double)field->r[i] : 1;
}

static void expect_nothing_ahead(struct dice *dice, const struct field *field, int i, double side,
                                 double horizon)
{
    for (int k = 0; k < 8; k++) {
        const double share = k ? dice_uniform(dice) : 0,
                     r = (double)field->r[i] + share * ring_width(field, i);
        const double slope = horizon * exp(k & 1 ? 0 : dice_between(dice, 0, 3));
        const struct ray ray = ray_from(field, r, dice_between(dice, -3.1416, 3.1416), slope, side);
        const double least = least_height(field, &ray), rounding = ray_rounding(field, &ray, 0);
        if (least < -16 * rounding)
            fail_msg("ring %d of %d, r %.9g, slope %g: met at %g roundings", i, field->n, r, slope,
                     least / rounding);
    }
}

/* True if a ray from an end of ring i, inwards or outwards, meets the surface. */
static bool meets_below(const struct field *field, int i, double side, double slope)
{
    for (int k = 0; k < 4; k++) {
        if (k > 1 && i + 1 == field->n) continue;
        const double r = (double)field->r[i + k / 2];
        const struct ray ray = ray_from(field, r, k & 1 ? 3.14159265358979 : 0, slope, side);
        if (least_height(field, &ray) < -16 * ray_rounding(field, &ray, 0)) return true;
    }
    return false;
}

static void above_it_nothing_is_met(void **state)
{
    (void)state;
    struct dice dice = dice_new(1);
    long seen = 0, met = 0;
    for (int k = 0; k < FIELDS; k++) {
        const struct field field = field_random(&dice, k % 3 ? 1 : 10);
        const struct horizons horizons = horizons_of(&field);
        for (int i = 0; i < field.n; i++) {
            for (int side = -1; side <= 1; side += 2) {
                const double horizon = (double)(side > 0 ? horizons.below : horizons.above)[i];
                expect_nothing_ahead(&dice, &field, i, side, horizon);
                if (horizon < 0.1) continue;
                seen++;
                met += meets_below(&field, i, side, 0.7 * horizon);
            }
        }
    }
    print_message("%ld of %ld horizons are met from a little below\n", met, seen);
    assert_true(seen > 5000);
    assert_int_equal(met, seen);
}

static void a_wall_is_seen_from_afar_as_from_afar(void **state)
{
    (void)state;
    const double r[] = {0, 0.5, 1, 1.001}, z[] = {0, 0, 0, -0.5};
    const struct field field = field_of(COUNT(r), r, z);
    const struct horizons horizons = horizons_of(&field);
    const double expected[] = {0.5 / 0.501, 500, 500, 0};
    for (int i = 0; i < field.n; i++) {
        assert_true(fabs((double)horizons.above[i] - 0.001 - 1.001 * expected[i]) < 1e-3 * (1 + expected[i]));
        assert_true((double)horizons.below[i] < 0.0011 || i >= 2);
    }
}

/* Radii that differ in a file may be equal in single precision, which makes the ring upright. */
static void an_upright_ring_hides_nothing(void **state)
{
    (void)state;
    const real r[] = {0, 1, 1, 2}, z[] = {0, 0, (real)0.5, 0};
    real horizon[4];
    int scratch[4];
    const struct cml_vec up = {(real)0.1, 0, (real)-0.99};
    for (int side = -1; side <= 1; side += 2) {
        cml_ring_horizons(r, z, 4, (real)side, scratch, horizon);
        for (int i = 0; i < 3; i++) assert_false(cml_heads_away(horizon[i], up, -1));
        assert_true(horizon[3] < CML_INFINITY);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(above_it_nothing_is_met),
        cmocka_unit_test(a_wall_is_seen_from_afar_as_from_afar),
        cmocka_unit_test(an_upright_ring_hides_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
