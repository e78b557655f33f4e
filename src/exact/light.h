/* What shines on a stack from above, as adding-doubling takes it: shares of light that comes the same from
 * all directions, of parallel beams, and of the rest, as many rays as it takes. How wide beams are, and where
 * they stand, is no matter for totals. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "scene/scene.h"

struct cml_exact_ray {
    double cosine; /* of the angle to +z in medium 0, 0 < cosine <= 1 */
    double share;  /* of the light */
};

struct cml_exact_light {
    double diffuse; /* share of the light that has the same radiance in all directions */
    int num_beams;
    struct cml_exact_ray *beam; /* [num_beams] parallel ones, falling cosines */
    int num_samples;
    struct cml_exact_ray *sample; /* [num_samples] of light whose directions are spread */
};

/* The light of a scene's beams, shining on planes in place of all boundaries, the first at z = top.
 * CML_E_INPUT: a beam starts below that ("FILE:LINE: beam: z = ..."), or out of memory; *light is empty then,
 * else the caller clears it. */
CML_NODISCARD cml_status cml_exact_light_create(const struct cml_scene *scene, double top,
                                                struct cml_exact_light *light, struct cml_error *err);
/* Whether adding-doubling takes the light, all of which comes from above these planes, and the backing, which
 * is no metal. */
bool cml_exact_knows(const struct cml_scene *scene, double top);

void cml_exact_light_clear(struct cml_exact_light *light);

/* The share of parallel light at normal incidence. */
double cml_exact_light_normal(const struct cml_exact_light *light);

/* A function of x is known by its values at `count` <= 64 Chebyshev nodes of (low, high), which fall in i.
 * Adds to share[count] what each of them counts for in the sum over `samples` samples at x[k]. */
double cml_exact_node(double low, double high, int count, int i);
void cml_exact_gather(const double *x, const struct cml_exact_ray *sample, int samples, double low,
                      double high, int count, double *share);
