/* Totals of plane layers without photons, by adding-doubling [van de Hulst, Multiple Light Scattering, 1980;
 * Prahl, van Gemert, Welch, Applied Optics 32, 559-568 (1993)]. Knows no surfaces, engines or packets: it
 * judges them. SPDX-License-Identifier: MIT */
#pragma once

#include "exact/directions.h"

/* Rsp as the program splits it off (P1), Rd the rest of what is reflected, A what
 * all layers absorb, Tt what is transmitted, ballistic light with it, or what a backing keeps; from
 * CML_EXACT_LAYERS on, what layers 1, 2 ... absorb. */
enum cml_exact_share {
    CML_EXACT_RSP,
    CML_EXACT_RD,
    CML_EXACT_A,
    CML_EXACT_TT,
    CML_EXACT_BACKING,
    CML_EXACT_LAYERS
};

struct cml_exact_options {
    double tolerance;                      /* the order rises until no error is larger */
    double most_work;                      /* multiplications after which it does not rise any more */
    double walks;                          /* at each rough boundary, of each order */
    const struct cml_backing_def *backing; /* mirror or lambertian; NULL: none; cml_exact_scene has its own */
    const struct cml_rough_def *rough;     /* [num_layers + 1] of boundaries; NULL: smooth; likewise */
};

struct cml_exact {
    int count;      /* CML_EXACT_LAYERS + num_layers */
    double *value;  /* [count] shares of the incident light */
    double *error;  /* [count] no less than the error of the value, as far as can be known */
    int order;      /* nodes over a quarter of a circle */
    double walks;   /* at each rough boundary; 0: all are smooth */
    bool converged; /* all errors are within the tolerance, or as small as the walks let them be */
};

/* media: [num_layers + 2], their thicknesses those of the layers: boundaries are planes. The order rises by
 * factors of sqrt(2) up to 362. An error is twice the larger change from half the order and from the one
 * between, and by how much the shares do not add up to 1. With rough boundaries an error is at least four
 * standard errors, from the spread of parts of the walks. Each order walks anew, and the order rises until
 * its changes are no larger than that. On success the caller clears *exact. CML_E_INPUT:
 * out of memory; CML_E_NUMERIC: too much work for the least three orders, or numbers beyond double precision.
 */
CML_NODISCARD cml_status cml_exact_solve(const struct cml_medium_def *media, int num_layers,
                                         const struct cml_exact_light *light,
                                         const struct cml_exact_options *options, struct cml_exact *exact,
                                         struct cml_error *err);

/* cml_exact_solve for a scene without bodies, whose light comes from above (else CML_E_INPUT, by name).
 * depth: [num_layers + 1] of the boundaries, cm; NULL: their nominal depths. Planes there in place of all
 * shapes are the scene's flat twin. */
CML_NODISCARD cml_status cml_exact_scene(const struct cml_scene *scene, const double *depth,
                                         const struct cml_exact_options *options, struct cml_exact *exact,
                                         struct cml_error *err);

void cml_exact_clear(struct cml_exact *exact);

/* The largest error of all shares. */
double cml_exact_worst(const struct cml_exact *exact);
