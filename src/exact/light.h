/* The light on a stack from above, as adding-doubling takes it: diffuse light, parallel beams, and rays that
 * stand for spread light. Widths and positions of beams do not matter for totals. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "base/status.h"
#include "scene/scene.h"

/* A parallel ray: its direction and its share of the light. */
struct cml_exact_ray {
    double cosine; /* cosine of the angle to +z in medium 0, 0 < cosine <= 1 */
    double share;  /* share of all light */
};

/* The light on a stack as three sums: diffuse, parallel, and sampled light; owns its arrays. */
struct cml_exact_light {
    double diffuse; /* share of diffuse light, whose radiance is equal in all directions */
    int num_beams;
    struct cml_exact_ray *beam; /* [num_beams] parallel beams, sorted by falling cosine */
    int num_samples;
    struct cml_exact_ray *sample; /* [num_samples] rays that stand for light with spread directions */
};

/* Collects the light of a scene's beams on planes that replace all boundaries, the first at z = top.
 * CML_E_INPUT: a beam starts below that plane ("FILE:LINE: beam: z = ..."), or out of memory. The caller
 * clears *light, also after a failure. */
CML_NODISCARD cml_status cml_exact_light_create(const struct cml_scene *scene, double top,
                                                struct cml_exact_light *light, struct cml_error *err);
/* True if adding-doubling can treat the scene's light, backing and boundary 0: all light comes from above the
 * plane z = top, the backing is not a metal, and boundary 0 has no face or port. */
bool cml_exact_knows(const struct cml_scene *scene, double top);

void cml_exact_light_clear(struct cml_exact_light *light);

/* Returns the share of parallel light at normal incidence. */
double cml_exact_light_normal(const struct cml_exact_light *light);

/* Interpolation of a function at `count` <= 64 Chebyshev nodes of (low, high). cml_exact_node returns node i;
 * nodes fall with i. cml_exact_gather adds to share[count] the weights with which the function's values at
 * the nodes make up its sum over `samples` samples at x[k]. */
double cml_exact_node(double low, double high, int count, int i);
void cml_exact_gather(const double *x, const struct cml_exact_ray *sample, int samples, double low,
                      double high, int count, double *share);
