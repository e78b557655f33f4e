/* SPDX-License-Identifier: MIT */
#include "scene/specular.h"

#include <math.h>

/* Returns the reflectance between two indices at normal incidence. */
static double normal_reflectance(double n1, double n2)
{
    return pow((n1 - n2) / (n1 + n2), 2);
}

/* Light goes up and down in a clear layer many times, and the sum over all passages has a closed form: the
 * share (1 - r1) / (1 - r1 r2) of the light reaches the layer's lower face, which reflects the share r2 of
 * this light upwards. */
struct cml_specular cml_specular_split(const struct cml_medium_def *media, double n, int num_layers,
                                       bool planes)
{
    const bool glass = media[1].mua == 0 && media[1].mus == 0 && num_layers > 1 && planes;
    const double r1 = normal_reflectance(n, media[1].n),
                 r2 = glass ? normal_reflectance(media[1].n, media[2].n) : 0;
    return (struct cml_specular){.glass = glass,
                                 .reflected = r1 + (1 - r1) * (1 - r1) * r2 / (1 - r1 * r2),
                                 .between = (1 - r1) * r2 / (1 - r1 * r2)};
}
