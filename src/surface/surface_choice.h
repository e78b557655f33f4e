/* Chooses how fine a tessellation must be for a requested bias, and estimates bias and cost of cones and
 * meshes. The estimates come from the constants in surface_choice.c; bench/accuracy/accuracy.py measures
 * these constants. No surface is made here, and no engine is known. A measurement decides which surfaces may
 * become planes (engine/plane_trial.h). SPDX-License-Identifier: MIT */
#pragma once

#include "boundary.h"
#include "surface/mesh/mesh_surface.h"
#include "surface/tessellate.h"

struct cml_surface_set;

struct cml_surface_options {
    enum cml_surface_kind
        force; /* forced kind; CML_SURFACE_AUTO: choose; CML_SURFACE_CONE does not change meshes and planes */
    struct cml_tessellation tessellation;
    double tolerance; /* largest relative bias of totals and profiles, from which tessellation.tolerance is
                         computed; 0: the caller has set tessellation.tolerance */
    enum cml_mesh_search search;
    struct cml_mesh_budget budget;        /* for each tessellation; file, line and boundary are ignored */
    const struct cml_surface_set *shared; /* surfaces of another scene, made with the same options; surfaces
                                             of shapes that both scenes share are shared, too; NULL: none */
    const double *origin; /* scene position where x and y of queries are 0; set by cml_surfaces_create */
    bool may_flatten;     /* allows cml_make_harmless_planes to make planes; cml_surfaces_create ignores it */
};

/* Estimated bias and cost of a boundary's representation. */
struct cml_expectation {
    double bias;      /* relative bias of totals and profiles; 0: exact but for rounding; infinite: unknown */
    double query_ns;  /* time of one search for a crossing on the benchmark's machine, ns; 0 for planes */
    double deviation; /* radial deviation of a tessellation, as a share of the last radius; else 0 */
};

/* Returns the tessellation that keeps the options' tolerance. */
struct cml_tessellation cml_choice_tessellation(const struct cml_surface_options *options);

/* Returns the estimated cost of cones with the given number of rings; their bias is 0. */
struct cml_expectation cml_choice_expect_cones(int rings);

/* Returns the estimate for a tessellated heightfield under these options. */
struct cml_expectation cml_choice_expect_tessellation(const struct cml_surface_options *options);

/* Returns the estimate for a triangle mesh that the user gave; its bias is 0. */
struct cml_expectation cml_choice_expect_mesh(void);
