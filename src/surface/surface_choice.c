/* SPDX-License-Identifier: MIT */
#include "surface/surface_choice.h"

#include <math.h>

/* Bias per radial deviation, the larger of totals and profile, rounded up from the worst scene of
 * bench/accuracy.sh ("bias / deviation" of its reading). Vertex normals smooth the edges between rings: their
 * bias does not shrink with the triangles, so that only the facets' is asked of the tessellation. */
static double bias_per_deviation(const struct cml_tessellation *tessellation)
{
    static const double of[3][2] = {[CML_NORMALS_FACET] = {8.0, 9.0},
                                    [CML_NORMALS_VERTEX] = {8.0, 9.0},
                                    [CML_NORMALS_ANALYTIC] = {2.0, 6.0}};
    return of[tessellation->normals][tessellation->inscribed];
}

/* Time, from the same reading ("a query costs"). Cones cost less than their tessellation from one ring to
 * 1e4, and have no bias to pay for: a radial field is a mesh only where it is forced to be one. */
#define CONE_NS 77.0
#define RING_NS 0.02
#define MESH_NS 436.0

struct cml_tessellation cml_choice_tessellation(const struct cml_surface_options *options)
{
    struct cml_tessellation tessellation = options->tessellation;
    if (options->tolerance > 0)
        tessellation.tolerance = options->tolerance / bias_per_deviation(&tessellation);
    return tessellation;
}

/* A shift by h changes an optical depth by mut h, a slope turns a normal by as much. Both count in full,
 * which the charts never saw. */
double cml_choice_plane_bias(double height, double steepest, double mut)
{
    return mut * height + steepest;
}

static double plane_bias(const struct cml_radial *radial, const double mut[2])
{
    double height = 0, steepest = 0;
    const int last = radial->n - 1;
    for (int i = 0; i < last; i++) {
        height = fmax(height, fabs(radial->h[i] - radial->h[last]));
        steepest =
            fmax(steepest, fabs((radial->h[i + 1] - radial->h[i]) / (radial->r[i + 1] - radial->r[i])));
    }
    return cml_choice_plane_bias(height, steepest, fmax(mut[0], mut[1]));
}

struct cml_expectation cml_choice_expect_mesh(void)
{
    return (struct cml_expectation){.query_ns = MESH_NS};
}

struct cml_expectation cml_choice_expect(enum cml_surface_kind kind, const struct cml_radial *radial,
                                         const double mut[2], const struct cml_surface_options *options)
{
    if (kind == CML_SURFACE_PLANE) return (struct cml_expectation){.bias = plane_bias(radial, mut)};
    if (kind == CML_SURFACE_CONE) return (struct cml_expectation){.query_ns = CONE_NS + RING_NS * radial->n};
    const struct cml_tessellation tessellation = cml_choice_tessellation(options);
    struct cml_expectation expectation = cml_choice_expect_mesh();
    expectation.deviation = tessellation.tolerance;
    expectation.bias = tessellation.normals == CML_NORMALS_VERTEX
                           ? INFINITY
                           : tessellation.tolerance * bias_per_deviation(&tessellation);
    return expectation;
}

enum cml_surface_kind cml_choose_radial(const struct cml_radial *radial, const double mut[2],
                                        const struct cml_surface_options *options,
                                        struct cml_expectation *expectation)
{
    *expectation = cml_choice_expect(CML_SURFACE_PLANE, radial, mut, options);
    if (options->may_flatten && expectation->bias <= options->tolerance) return CML_SURFACE_PLANE;
    *expectation = cml_choice_expect(CML_SURFACE_CONE, radial, mut, options);
    return CML_SURFACE_CONE;
}
