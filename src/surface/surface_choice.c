/* Chooses tessellations, and estimates the bias and cost of representations. SPDX-License-Identifier: MIT */
#include "surface/surface_choice.h"

#include <math.h>

/* Returns the relative bias per radial deviation: the larger one of totals and profiles. The table is rounded
 * up from the worst scene of bench/accuracy/accuracy.py ("bias / deviation" in its output). Vertex normals
 * smooth the edges between rings, and this smoothing causes a bias that more triangles do not reduce. For
 * vertex normals the table therefore holds the bias of the facets alone. */
static double bias_per_deviation(const struct cml_tessellation *tessellation)
{
    static const double of[3][2] = {[CML_NORMALS_FACET] = {8.0, 9.0},
                                    [CML_NORMALS_VERTEX] = {8.0, 9.0},
                                    [CML_NORMALS_ANALYTIC] = {2.0, 6.0}};
    return of[tessellation->normals][tessellation->inscribed];
}

/* Time per query in ns, from the same benchmark ("a query costs"). From one ring to 1e4 rings, cones cost
 * less than their tessellation and have no bias. A radial heightfield is therefore a mesh only if the user
 * forces it. */
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

struct cml_expectation cml_choice_expect_mesh(void)
{
    return (struct cml_expectation){.query_ns = MESH_NS};
}

struct cml_expectation cml_choice_expect_cones(int rings)
{
    return (struct cml_expectation){.query_ns = CONE_NS + RING_NS * rings};
}

struct cml_expectation cml_choice_expect_tessellation(const struct cml_surface_options *options)
{
    const struct cml_tessellation tessellation = cml_choice_tessellation(options);
    struct cml_expectation expectation = cml_choice_expect_mesh();
    expectation.deviation = tessellation.tolerance;
    expectation.bias = tessellation.normals == CML_NORMALS_VERTEX
                           ? INFINITY
                           : tessellation.tolerance * bias_per_deviation(&tessellation);
    return expectation;
}
