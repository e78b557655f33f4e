/* Totals of plane layers without photons, by adding-doubling [van de Hulst, Multiple Light Scattering, 1980;
 * Prahl, van Gemert, Welch, Applied Optics 32, 559-568 (1993)]. These totals serve to check simulated ones,
 * so this module uses no surfaces, engines or packets. SPDX-License-Identifier: MIT */
#pragma once

#include "exact/directions.h"

/* Shares of the incident light. RSP is the specular reflection as rule P1 of kernels/README.md defines it, RD
 * the rest of the reflection, A the absorption of all layers, TT the transmission with ballistic light,
 * BACKING the absorption of a backing. CML_EXACT_LAYERS is the absorption of layer 1, the next number that of
 * layer 2, and so on. */
enum cml_exact_share {
    CML_EXACT_RSP,
    CML_EXACT_RD,
    CML_EXACT_A,
    CML_EXACT_TT,
    CML_EXACT_BACKING,
    CML_EXACT_LAYERS
};

/* Options of cml_exact_solve: accuracy, allowed work, and the parts of the scene beside layers and light. */
struct cml_exact_options {
    double tolerance; /* the order rises until no error exceeds this */
    /* Number of multiplications beyond which the order does not rise further. */
    double most_work;
    double walks; /* number of walks at each rough boundary, each time that the order rises */
    /* Mirror or lambertian backing; NULL: none. cml_exact_scene ignores the member and takes the scene's. */
    const struct cml_backing_def *backing;
    /* [num_layers + 1] roughness of boundaries; NULL: all smooth; cml_exact_scene uses the scene's */
    const struct cml_rough_def *rough;
};

/* The shares of a scene with their errors; owns its arrays. */
struct cml_exact {
    int count;      /* number of shares, CML_EXACT_LAYERS + num_layers */
    double *value;  /* [count] shares of the incident light */
    double *error;  /* [count] estimated upper bounds of the errors of the shares */
    int order;      /* number of nodes over a quarter of a circle */
    double walks;   /* number of walks at each rough boundary; 0: all boundaries are smooth */
    bool converged; /* all errors are within the tolerance, or as small as the number of walks allows */
};

/* Computes the shares for plane layers. media: [num_layers + 2], with the layers' thicknesses. The order
 * rises by factors of sqrt(2) up to 362. An error is twice the larger of two changes, from half the order and
 * from the order between, plus the amount by which the shares miss the sum 1. With rough boundaries it is at
 * least four standard errors, from the spread of parts of the walks. Each order uses new walks, and the order
 * rises until its changes are no larger than these errors. On success the caller clears *exact. CML_E_INPUT:
 * out of memory; CML_E_NUMERIC: the first three orders take too much work, or numbers leave double
 * precision. */
CML_NODISCARD cml_status cml_exact_solve(const struct cml_medium_def *media, int num_layers,
                                         const struct cml_exact_light *light,
                                         const struct cml_exact_options *options, struct cml_exact *exact,
                                         struct cml_error *err);

/* Computes the shares of a scene without bodies whose light comes from above; other scenes are refused by
 * name (CML_E_INPUT). depth: [num_layers + 1] depths of the planes that replace the boundaries, cm; NULL:
 * their nominal depths. The scene with planes in place of all shapes is called its flat twin. */
CML_NODISCARD cml_status cml_exact_scene(const struct cml_scene *scene, const double *depth,
                                         const struct cml_exact_options *options, struct cml_exact *exact,
                                         struct cml_error *err);

void cml_exact_clear(struct cml_exact *exact);

/* Returns the largest error of all shares. */
double cml_exact_worst(const struct cml_exact *exact);
