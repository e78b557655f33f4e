/* SPDX-License-Identifier: MIT */
#include "scene/specular.h"

#include <math.h>

/* Returns the reflectance of a boundary at normal incidence. */
static double normal_reflectance(const struct cml_medium_def *m, int boundary)
{
    return pow((m[boundary].n - m[boundary + 1].n) / (m[boundary].n + m[boundary + 1].n), 2);
}

/* Computes the specular shares. Light goes up and down in a clear layer many times, and the sum over all
 * passages has a closed form: the share (1 - r1) / (1 - r1 r2) of the light reaches the layer's lower face,
 * which reflects the share r2 of this light upwards. */
struct cml_specular cml_specular_split(const struct cml_medium_def *media, int num_layers, bool planes)
{
    const bool glass = media[1].mua == 0 && media[1].mus == 0 && num_layers > 1 && planes;
    const double r1 = normal_reflectance(media, 0), r2 = glass ? normal_reflectance(media, 1) : 0;
    return (struct cml_specular){.glass = glass,
                                 .reflected = r1 + (1 - r1) * (1 - r1) * r2 / (1 - r1 * r2),
                                 .between = (1 - r1) * r2 / (1 - r1 * r2)};
}
