/* Which representation a boundary gets: plane, cones or mesh, and how fine, from the bias that is asked for.
 * The rules are the constants of surface_choice.c; bench/accuracy.sh measures them again. Knows no engine and
 * makes no surface. SPDX-License-Identifier: MIT */
#ifndef CML_SURFACE_CHOICE_H
#define CML_SURFACE_CHOICE_H

#include "scene/radial.h"
#include "boundary.h"
#include "surface/mesh/mesh_surface.h"
#include "surface/tessellate.h"

struct cml_surface_options {
    enum cml_surface_kind
        force; /* CML_SURFACE_AUTO: choose; CML_SURFACE_CONE leaves meshes meshes and planes planes */
    struct cml_tessellation tessellation;
    double tolerance; /* relative bias asked of totals and profiles; tessellation.tolerance follows from it.
                       * 0: tessellation.tolerance counts as it stands */
    enum cml_mesh_search search;
    struct cml_mesh_budget budget; /* of each tessellation; its file, line and boundary are not read */
    bool may_flatten; /* a surface whose effect is expected below the tolerance may become a plane */
};

/* What to expect of a boundary's representation. */
struct cml_expectation {
    double bias;      /* relative, of totals and profiles; 0: exact but for rounding; infinite: unbounded */
    double query_ns;  /* of one question for a crossing, on the machine that measured; 0 for planes */
    double deviation; /* radial, of a tessellation, as a share of the last radius; else 0 */
};

/* The tessellation that keeps the tolerance. */
struct cml_tessellation cml_choice_tessellation(const struct cml_surface_options *options);

/* Relative bias to expect when a surface is replaced by the plane in which it goes on outside: height [cm]:
 * its largest distance from there, steepest: its largest slope, mut [1/cm]: the larger of the media beside
 * it. */
double cml_choice_plane_bias(double height, double steepest, double mut);

/* What cones or a mesh of this field cost, and how biased they are. mut [1/cm]: of the media above and below.
 */
struct cml_expectation cml_choice_expect(enum cml_surface_kind kind, const struct cml_radial *radial,
                                         const double mut[2], const struct cml_surface_options *options);

/* Of a triangle mesh as the user gave it. */
struct cml_expectation cml_choice_expect_mesh(void);

/* CML_SURFACE_PLANE or CML_SURFACE_CONE for a merged, curved field (radial->n >= 2); *expectation is that of
 * the choice. options->force is CML_SURFACE_AUTO. */
enum cml_surface_kind cml_choose_radial(const struct cml_radial *radial, const double mut[2],
                                        const struct cml_surface_options *options,
                                        struct cml_expectation *expectation);

#endif
