/* Light that runs into grooves between interpolated normals (P5), on sheets of random heights. In single and
 * double precision, packets come out again after equal numbers of steps. Both share numbers and physics.
 * SPDX-License-Identifier: MIT */
#include "flight.h"

#include "lib/mesh_shapes.h"

#define PHOTONS 1000

/* Writes a scene with a random sheet, whose steepest facets have about this slope. */
static void write_scene(const char *obj, double slope, double n, double angle, char *text, size_t size)
{
    static struct patch patch;
    patch_make(&patch, 7, slope / GRID, 0, 0, 0);
    patch_write(&patch, obj);
    snprintf(text, size,
             "1.0\n1\ngrooves A\n1\n0.01 0.01\n1 1 1\nbeam disk 0.4 angle=%g\n1\n1\nm \"%s\" normals=vertex\n"
             "%g 1 10 0.8 30\n1\n",
             angle, obj, n);
}

/* Returns the boundary events of all packets. *most: events of the packet that has the most. */
static double count_events(const char *text, const char *engine, uint32_t *most)
{
    const struct flight_options with = {.engine = engine, .kind = CML_SURFACE_AUTO};
    struct flight flight;
    double sum = 0;
    flight_open(text, &with, &flight);
    *most = 0;
    for (uint64_t i = 0; i < PHOTONS; i++) {
        const struct cml_fate_record record = fly(&flight, i);
        assert_int_not_equal(record.fate, CML_FATE_LOST);
        sum += record.boundary_events;
        if (record.boundary_events > *most) *most = record.boundary_events;
    }
    flight_close(&flight);
    return sum;
}

/* Compares the sums of boundary events in both precisions, because packets of steep sheets soon take
 * different ways.
 *
 * The number of events of a packet scatters by about its mean, and one packet in five differs. A packet that
 * stays in a groove has a thousand. */
static void expect_same(const char *obj, double slope, double n, double angle)
{
    char text[512];
    uint32_t most, most_of_reference;
    write_scene(obj, slope, n, angle, text, sizeof text);
    const double events = count_events(text, "cpu", &most),
                 expected = count_events(text, "reference", &most_of_reference);
    printf("slope %g, n %g, %g degrees: %g events of %g, at most %u and %u\n", slope, n, angle, events,
           expected, most, most_of_reference);
    assert_true(fabs(events - expected) <= 0.05 * expected);
    assert_true(most < CML_SHADED_LIMIT && most_of_reference < CML_SHADED_LIMIT);
}

static void both_precisions_leave_grooves_alike(void **state)
{
    (void)state;
    static const double slopes[] = {10, 100, 300}, indices[] = {0.7, 1.4, 2}, angles[] = {0, 45, 80};
    char folder[] = "/tmp/cml_grooves_XXXXXX", obj[64];
    assert_non_null(mkdtemp(folder));
    snprintf(obj, sizeof obj, "%s/steep.obj", folder);
    for (int s = 0; s < COUNT(slopes); s++)
        for (int i = 0; i < COUNT(indices); i++)
            for (int a = 0; a < COUNT(angles); a++) expect_same(obj, slopes[s], indices[i], angles[a]);
    remove(obj);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(both_precisions_leave_grooves_alike)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
