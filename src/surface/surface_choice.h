/* How fine a tessellation must be for the bias that is asked for, and what bias and cost to expect of cones
 * and meshes. The rules are the constants of surface_choice.c; bench/accuracy/accuracy.py measures them
 * again. Knows no engine and makes no surface; which surfaces may be planes is measured
 * (engine/plane_trial.h). SPDX-License-Identifier: MIT */
#pragma once

#include "boundary.h"
#include "surface/mesh/mesh_surface.h"
#include "surface/tessellate.h"

struct cml_surface_set;

struct cml_surface_options {
    enum cml_surface_kind
        force; /* CML_SURFACE_AUTO: choose; CML_SURFACE_CONE leaves meshes meshes and planes planes */
    struct cml_tessellation tessellation;
    double tolerance; /* relative bias asked of totals and profiles; tessellation.tolerance follows from it.
                       * 0: tessellation.tolerance counts as it stands */
    enum cml_mesh_search search;
    struct cml_mesh_budget budget;        /* of each tessellation; its file, line and boundary are not read */
    const struct cml_surface_set *shared; /* of another scene, made with these options: those of shapes that
                                           * this scene shares are shared, too. NULL: none */
    const double *origin; /* scene position of x and y of queries; cml_surfaces_create finds and sets it */
    bool may_flatten;     /* cml_make_harmless_planes may make planes; cml_surfaces_create never does */
};

/* What to expect of a boundary's representation. */
struct cml_expectation {
    double bias;      /* relative, of totals and profiles; 0: exact but for rounding; infinite: unbounded */
    double query_ns;  /* of one question for a crossing, on the machine that measured; 0 for planes */
    double deviation; /* radial, of a tessellation, as a share of the last radius; else 0 */
};

/* The tessellation that keeps the tolerance. */
struct cml_tessellation cml_choice_tessellation(const struct cml_surface_options *options);

struct cml_expectation cml_choice_expect_cones(int rings);
struct cml_expectation cml_choice_expect_tessellation(const struct cml_surface_options *options);

/* What to expect of a triangle mesh as the user gave it. */
struct cml_expectation cml_choice_expect_mesh(void);
