/* Compares maps and facets with the totals, exactly, and with radial bins and results on paper, on every
 * engine and kind of boundary.
 * SPDX-License-Identifier: MIT */
#include "flight.h"

#include "output/report_parts.h"
#include "surface/surface_facets.h"

#include <math.h>

#define COUNT(array) (int)(sizeof(array) / sizeof *(array))

/* A scene and the tally of its flight. */
struct shot {
    struct flight flight;
    struct cml_tally tally;
};

/* Adds the cells of all groups of photons to those of the first group. */
static void join_groups(uint64_t *cells, size_t groups, size_t n)
{
    for (size_t g = 1; g < groups; g++)
        for (size_t i = 0; i < n; i++) cells[i] += cells[g * n + i];
}

static void shoot(const char *text, const char *engine, enum cml_surface_kind kind, uint64_t photons,
                  struct shot *shot)
{
    struct cml_error err;
    const struct flight_options with = {
        .engine = engine, .kind = kind, .normals = CML_NORMALS_ANALYTIC, .absorption = true};
    const struct cml_engine_options options = {.absorption = true};
    flight_open(text, &with, &shot->flight);
    const struct cml_tally_grid grid =
        cml_engine_grid(&shot->flight.list.scenes[0], &shot->flight.surfaces, &options);
    require_ok(cml_tally_create(&grid, &shot->tally, &err), &err);
    require_ok(cml_engine_run_range(shot->flight.engine, shot->flight.self, 0, photons, &shot->tally, &err),
               &err);
    join_groups(shot->tally.A_rz, (size_t)cml_cell_groups(&grid), shot->tally.layout.size[CML_ARRAY_A_rz]);
    join_groups(shot->tally.Rd_ra, (size_t)cml_cell_groups(&grid), shot->tally.layout.size[CML_ARRAY_Rd_ra]);
    join_groups(shot->tally.Tt_ra, (size_t)cml_cell_groups(&grid), shot->tally.layout.size[CML_ARRAY_Tt_ra]);
    join_groups(shot->tally.A_xyz, cml_groups_of(grid.voxel_step), grid.voxel_step);
    join_groups(shot->tally.Rd_xya, cml_groups_of(grid.map_once.step), grid.map_once.step);
    join_groups(shot->tally.facets, cml_groups_of(grid.facet_step), grid.facet_step);
}

static void clear(struct shot *shot)
{
    cml_tally_free(&shot->tally);
    flight_close(&shot->flight);
}

/* A scene that is rough on both sides, so that packets enter and leave again. Part of the light leaves
 * outside the map. */
static const char *const rough = "1.0\n1\nrough A\n1000\nbeam disk 0.4 at=0.1,0\nfacets\n"
                                 "0.02 0.02\n10 15 3\n#@ map 12 8 0.05 0.05 angles\n2\n1\n"
                                 "b 4 0.05 0.1 -0.03 0.15 0.04 0.2 0 0\n1.4 0.5 20 0.8 0.2\n"
                                 "1.3 0.2 5 0 0.3\nb 3 -0.1 0.2 0.1 0.2 0 0\n1.1\n";

static size_t num_facets(const struct shot *shot, int b)
{
    return cml_surface_facets(&shot->flight.surfaces.item[b], &shot->flight.list.scenes[0].map);
}

static uint64_t sum_of_bins(const uint64_t *cells, size_t rows, size_t na, size_t a)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < rows; i++) sum += cells[i * na + a];
    return sum;
}

static uint64_t sum_of_score(const struct shot *shot, int b, enum cml_facet_score score)
{
    size_t first = 0;
    for (int i = 0; i < b; i++) first += num_facets(shot, i);
    return sum_of_bins(shot->tally.facets + first * CML_FACET_SCORES, num_facets(shot, b), CML_FACET_SCORES,
                       score);
}

static void expect_totals(const struct shot *shot)
{
    const struct cml_tally *t = &shot->tally;
    const size_t pixels = (size_t)t->grid.nx * (size_t)t->grid.ny + 1, na = (size_t)t->grid.na;
    const size_t rows = (size_t)t->grid.nr + 1; /* one row for light beyond the grid */
    for (size_t a = 0; a < na; a++) {
        assert_int_equal(sum_of_bins(t->Rd_xya, pixels, na, a), sum_of_bins(t->Rd_ra, rows, na, a));
        assert_int_equal(sum_of_bins(t->Tt_xya, pixels, na, a), sum_of_bins(t->Tt_ra, rows, na, a));
        assert_true(t->Rd_xya[(pixels - 1) * na + a] > 0); /* outside the map */
    }
    const int last = shot->flight.surfaces.count - 1;
    assert_int_equal(sum_of_score(shot, 0, CML_FACET_ESCAPED), t->balance[CML_BALANCE_REFLECTED]);
    assert_int_equal(sum_of_score(shot, last, CML_FACET_ESCAPED), t->balance[CML_BALANCE_TRANSMITTED]);
    for (size_t i = 0; i < t->grid.facets; i++) {
        const uint64_t *score = t->facets + i * CML_FACET_SCORES;
        assert_int_equal(score[CML_FACET_IRRADIANCE_ABOVE] + score[CML_FACET_IRRADIANCE_BELOW],
                         score[CML_FACET_EXITANCE_ABOVE] + score[CML_FACET_EXITANCE_BELOW]);
    }
    /* light that escaped left the facet upwards; light that came back adds to the exitance */
    assert_true(sum_of_score(shot, 0, CML_FACET_EXITANCE_ABOVE) > t->balance[CML_BALANCE_REFLECTED]);
    assert_true(sum_of_score(shot, last, CML_FACET_EXITANCE_BELOW) > t->balance[CML_BALANCE_TRANSMITTED]);
}

static void sums_are_the_totals(void **state)
{
    (void)state;
    static const char *const engines[] = {"cpu", "reference"};
    for (int e = 0; e < COUNT(engines); e++)
        for (int kind = CML_SURFACE_CONE; kind <= CML_SURFACE_MESH; kind++) {
            struct shot shot;
            shoot(rough, engines[e], (enum cml_surface_kind)kind, 4000, &shot);
            expect_totals(&shot);
            clear(&shot);
        }
}

/* Tests flat rings as wide as the radial bins: the share of a ring in Rd and Tt equals that of the bin.
 * Rounding may put a packet on the other side of a ring. */
static void flat_rings_are_radial_bins(void **state)
{
    (void)state;
    struct shot shot;
    shoot("1.0\n1\nflat A\n1000\nbeam pencil angle=1\nfacets\n0.1 0.1\n1 4 1\n1\n1\n"
          "b 4 0 0.1 0 0.1 0 0.1 0 0\n1.4 0.5 20 0.5 0.3\nb 4 0 0.1 0 0.1 0 0.1 0 0\n1\n",
          "cpu", CML_SURFACE_CONE, 40000, &shot);
    const struct cml_tally *t = &shot.tally;
    assert_int_equal(t->grid.facets, 8);
    for (int i = 0; i < 4; i++) { /* the fourth ring is all light outside */
        const double up = (double)t->facets[i * CML_FACET_SCORES + CML_FACET_ESCAPED];
        const double down = (double)t->facets[(4 + i) * CML_FACET_SCORES + CML_FACET_ESCAPED];
        const double Rd = (double)t->Rd_ra[i] + (i == 3 ? (double)t->Rd_ra[4] : 0);
        const double Tt = (double)t->Tt_ra[i] + (i == 3 ? (double)t->Tt_ra[4] : 0);
        assert_true(Rd > 0 && fabs(up / Rd - 1) < 1e-3);
        assert_true(Tt > 0 && fabs(down / Tt - 1) < 1e-3);
    }
    clear(&shot);
}

#define HILL(top)                                                                                            \
    "1.0\n1\nlayers A\n1000\nmap 3 3 0.2 1000 volume" top "\n0.1 0.1\n4 5 1\n1\n1\n"                         \
    "b 3 0.1 0.5 0.05 0.5 0 0\n1.4 1 20 0.5 0.6\n1\n"

/* Tests a volume that holds all light: its layers equal the depth bins, and light outside them is counted
 * outside. The middle column of a coarse volume roughly equals the inner radial bins. */
static void layers_of_the_volume_are_depth_bins(void **state)
{
    (void)state;
    const size_t nz = 4, pixels = 9;
    struct shot shot;
    shoot(HILL(""), "cpu", CML_SURFACE_AUTO, 4000, &shot);
    const struct cml_tally *t = &shot.tally;
    uint64_t sideways = 0, beyond = 0;
    for (size_t i = 0; i <= (size_t)t->grid.nr; i++)
        beyond += t->A_rz[i * (nz + 2)] + t->A_rz[i * (nz + 2) + nz + 1];
    for (size_t z = 0; z < nz; z++) {
        uint64_t bin = 0, layer = 0;
        for (size_t i = 0; i <= (size_t)t->grid.nr; i++) bin += t->A_rz[i * (nz + 2) + z + 1];
        for (size_t i = 0; i < pixels; i++) layer += t->A_xyz[z * pixels + i];
        const uint64_t *row = t->A_xyz + z * pixels + 3; /* y in the middle, x rising */
        assert_true(row[1] > row[0] && row[1] > row[2] && layer == row[0] + row[1] + row[2]);
        assert_true(layer < bin && (double)layer > 0.7 * (double)bin);
        sideways += bin - layer;
    }
    assert_true(beyond > 0 && sideways > 0);
    assert_int_equal(t->A_xyz[nz * pixels], beyond + sideways);
    struct shot raised;
    shoot(HILL(" top=-0.1"), "cpu", CML_SURFACE_AUTO, 4000, &raised);
    uint64_t above = 0; /* the hill is now a layer of its own, and all other layers lie one deeper */
    for (size_t i = 0; i < pixels; i++) above += raised.tally.A_xyz[i];
    assert_true(above > 0);
    assert_memory_equal(raised.tally.A_xyz + pixels, t->A_xyz, (nz - 1) * pixels * sizeof *t->A_xyz);
    clear(&raised);
    clear(&shot);
}

/* Tests planes between which no packet meets roulette: the net flux into the region equals its absorption. */
static void the_flux_through_planes_is_what_the_balance_says(void **state)
{
    (void)state;
    static const char *const engines[] = {"cpu", "reference"};
    for (int e = 0; e < COUNT(engines); e++) {
        struct shot shot;
        shoot("1.0\n1\nflux A\n1000\nfacets\nmap 3 4 0.1 0.1\n0.1 0.1\n1 1 1\n3\n1\n1.5 0 0 0 0.1\n"
              "1.4 0.5 20 0.8 0.05\n1.3 1 5 0 0.1\n1.2\n",
              engines[e], CML_SURFACE_AUTO, 3000, &shot);
        const struct cml_tally *t = &shot.tally;
        uint64_t net[4];
        for (int b = 0; b < 4; b++) {
            net[b] = sum_of_score(&shot, b, CML_FACET_EXITANCE_BELOW) -
                     sum_of_score(&shot, b, CML_FACET_IRRADIANCE_BELOW);
            assert_true(sum_of_score(&shot, b, CML_FACET_IRRADIANCE_ABOVE) > 0);
            assert_int_equal(sum_of_score(&shot, b, CML_FACET_ESCAPED), 0);
        }
        assert_int_equal(t->balance[CML_BALANCE_ROULETTE] + t->balance[CML_BALANCE_GAINED], 0);
        assert_int_equal(sum_of_score(&shot, 0, CML_FACET_IRRADIANCE_ABOVE),
                         t->balance[CML_BALANCE_LAUNCHED]);
        assert_int_equal(sum_of_score(&shot, 0, CML_FACET_EXITANCE_ABOVE),
                         t->balance[CML_BALANCE_SPECULAR] + t->balance[CML_BALANCE_REFLECTED]);
        assert_int_equal(net[0] - net[1], t->A_l[1]);
        assert_int_equal(net[1] - net[2], t->A_l[2]);
        assert_int_equal(net[2] - net[3], t->A_l[3]);
        assert_int_equal(net[3], t->balance[CML_BALANCE_TRANSMITTED]);
        assert_int_equal(sum_of_score(&shot, 3, CML_FACET_IRRADIANCE_BELOW), 0);
        clear(&shot);
    }
}

/* Returns the score per launched packet. */
static double share_of_score(const struct shot *shot, int b, enum cml_facet_score score)
{
    return (double)sum_of_score(shot, b, score) / (double)shot->tally.balance[CML_BALANCE_LAUNCHED];
}

/* Tests a clear plate with no light from below: the light to and fro in it is a geometric series. */
static void light_between_the_faces_of_a_clear_plate_is_counted(void **state)
{
    (void)state;
    static const char *const engines[] = {"cpu", "reference"};
    const double r1 = 0.04, r2 = pow(0.1 / 2.9, 2), down = (1 - r1) / (1 - r1 * r2), unit = ldexp(1, -31);
    for (int e = 0; e < COUNT(engines); e++) {
        struct shot shot;
        shoot("1.0\n1\nplate A\n1000\nfacets\nmap 3 4 0.1 0.1\n0.1 0.1\n1 1 1\n2\n1\n1.5 0 0 0 0.1\n"
              "1.4 1e4 0 0 1\n1.4\n",
              engines[e], CML_SURFACE_AUTO, 3000, &shot);
        assert_true(fabs(share_of_score(&shot, 0, CML_FACET_IRRADIANCE_BELOW) - down * r2) < 2 * unit);
        assert_true(fabs(share_of_score(&shot, 0, CML_FACET_EXITANCE_BELOW) - down) < 2 * unit);
        assert_true(fabs(share_of_score(&shot, 1, CML_FACET_IRRADIANCE_ABOVE) - down) < 2 * unit);
        assert_true(fabs(share_of_score(&shot, 1, CML_FACET_EXITANCE_ABOVE) - down * r2) < 2 * unit);
        assert_true(fabs(share_of_score(&shot, 1, CML_FACET_EXITANCE_BELOW) - down * (1 - r2)) < 2 * unit);
        clear(&shot);
    }
}

/* Tests a beam that is not quite normal, and is therefore traced through the plate packet by packet: the
 * light must be equal within chance. A packet comes to a face more than once with a share of at most r1 r2:
 * binomial, 5 deviations. */
static void a_clear_plate_counts_the_same_for_traced_packets(void **state)
{
    (void)state;
    static const enum cml_facet_score scores[] = {CML_FACET_IRRADIANCE_BELOW, CML_FACET_EXITANCE_BELOW,
                                                  CML_FACET_IRRADIANCE_ABOVE, CML_FACET_EXITANCE_ABOVE};
    static const char *const lines[] = {"", "beam pencil angle=0.0001\n"};
    const double photons = 40000;
    struct shot shot[2];
    for (int i = 0; i < 2; i++) {
        char text[300];
        snprintf(text, sizeof text,
                 "1.0\n1\nplate A\n1000\nfacets\nmap 3 4 0.1 0.1\n%s0.1 0.1\n1 1 1\n2\n1\n1.5 0 0 0 0.1\n"
                 "1.9 5 1 0 1\n1.9\n",
                 lines[i]);
        shoot(text, "cpu", CML_SURFACE_AUTO, (uint64_t)photons, &shot[i]);
    }
    for (int b = 0; b < 2; b++)
        for (int s = 0; s < COUNT(scores); s++) {
            const double one = share_of_score(&shot[0], b, scores[s]),
                         other = share_of_score(&shot[1], b, scores[s]);
            const double deviation = sqrt(2 * fmax(one, 1e-3) / photons);
            if (fabs(one - other) > 5 * deviation)
                fail_msg("boundary %d, score %d: %g, %g", b, s, one, other);
        }
    clear(&shot[0]);
    clear(&shot[1]);
}

/* Tests a disk beam on a hill without any medium: the irradiance of a slope is the beam's times the cosine,
 * and all light goes on. Counts are binomial; 4.5 standard deviations. */
static void the_irradiance_of_a_slope_is_the_cosine(void **state)
{
    (void)state;
    const uint64_t photons = 100000;
    struct shot shot;
    shoot("1.0\n1\nhill A\n1000\nbeam disk 0.5\nfacets\n0.1 0.1\n1 1 1\n1\n1\n"
          "b 3 0.3 0.1 0.25 0.2 0 0\n1 0 0 0 0.3\n1\n",
          "cpu", CML_SURFACE_CONE, photons, &shot);
    const struct cml_surface_def *hill = &shot.flight.surfaces.item[0];
    const double beam = 3.14159265358979 * 0.25;
    assert_int_equal(shot.tally.grid.facets, 3);
    for (size_t i = 0; i < 2; i++) {
        const uint64_t *score = shot.tally.facets + i * CML_FACET_SCORES;
        const double cosine = 1 / hypot(1, hill->slope[i]);
        const double share = cosine * cml_surface_facet_area(hill, &shot.flight.list.scenes[0].map, i) / beam;
        const double measured = (double)score[CML_FACET_IRRADIANCE_ABOVE] * CML_WEIGHT_UNIT / (double)photons;
        assert_true(fabs(measured - share) < 4.5 * sqrt(share * (1 - share) / (double)photons));
        assert_int_equal(score[CML_FACET_EXITANCE_BELOW], score[CML_FACET_IRRADIANCE_ABOVE]);
        assert_int_equal(score[CML_FACET_EXITANCE_ABOVE] + score[CML_FACET_IRRADIANCE_BELOW], 0);
        assert_int_equal(score[CML_FACET_ESCAPED], 0);
    }
    clear(&shot);
}

/* Tests that drawn faces have the areas by which results are divided: exactly for triangles, as polygons for
 * rings. */
static void faces_have_their_areas(void **state)
{
    (void)state;
    for (int kind = CML_SURFACE_CONE; kind <= CML_SURFACE_MESH; kind++) {
        struct shot shot;
        struct cml_faces faces;
        struct cml_error err;
        size_t per_facet;
        shoot(rough, "cpu", (enum cml_surface_kind)kind, 1, &shot);
        const struct cml_surface_def *def = &shot.flight.surfaces.item[2];
        const struct cml_map_def *map = &shot.flight.list.scenes[0].map;
        const size_t facets = num_facets(&shot, 2);
        require_ok(cml_drawn_faces_of_boundary(def, &faces, &per_facet, &err), &err);
        assert_int_equal(faces.num_faces, (facets - 1) * per_facet);
        double flat = 0, areas = 0;
        for (size_t i = 0; i < faces.num_faces; i++) { /* area seen from above, by the shoelace rule */
            const uint32_t *corner = faces.corner + i * (size_t)faces.corners;
            for (int k = 0; k < faces.corners; k++) {
                const double *p = faces.point[corner[k]], *q = faces.point[corner[(k + 1) % faces.corners]];
                flat += 0.5 * (p[0] * q[1] - q[0] * p[1]);
            }
        }
        for (size_t i = 0; i + 1 < facets; i++) areas += cml_surface_facet_area(def, map, i);
        assert_true(fabs(fabs(flat) / (3.14159265358979 * 0.16) - 1) < 2e-3);
        const double exact = 3.14159265358979 * (0.2 * hypot(0.2, 0.2) + 0.6 * hypot(0.2, 0.1));
        assert_true(fabs(areas / exact - 1) < (kind == CML_SURFACE_CONE ? 1e-14 : 1e-2));
        assert_true(fabs(faces.point[0][2] - 0.6) < 1e-12); /* the tip, 0.1 cm below the nominal depth */
        assert_true(isinf(cml_surface_facet_area(def, map, facets - 1)));
        free(faces.point);
        free(faces.corner);
        clear(&shot);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_are_the_totals),
        cmocka_unit_test(flat_rings_are_radial_bins),
        cmocka_unit_test(layers_of_the_volume_are_depth_bins),
        cmocka_unit_test(the_flux_through_planes_is_what_the_balance_says),
        cmocka_unit_test(light_between_the_faces_of_a_clear_plate_is_counted),
        cmocka_unit_test(a_clear_plate_counts_the_same_for_traced_packets),
        cmocka_unit_test(the_irradiance_of_a_slope_is_the_cosine),
        cmocka_unit_test(faces_have_their_areas),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
