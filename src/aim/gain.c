/* What windows gain (P19), by formulas. Their numbers are fitted to flights with and without windows:
 * bench/choices/aim.py flies them again, and its table has the gains that were measured beside those of these
 * formulas. SPDX-License-Identifier: MIT */
#include "aim/gain.h"

#include <math.h>

/* Where much light arrives windows gain little, and what is reflected pays for them. */
double cml_windows_power(double worth)
{
    return worth > 1e-2 ? 0.5 : worth > 1e-5 ? 0.75 : 0.9;
}

/* Of light that comes out below: V, the variance of one packet over the square of its mean, is 0.008 / worth,
 * as packets weigh little there, and becomes about log(V)^2. Nothing where more than 5e-3 of the light
 * arrives. */
double cml_gain_below(double worth)
{
    const double V = 0.008 / worth, least = 7.4; /* below that the rule turns */
    if (!(worth < 5e-3)) return 0;
    return V > least ? V / pow(log(V), 2) : 2;
}

/* The share of a detector's gain that its spread about the aim leaves. Of a rectangle the middle is the aim,
 * so a narrow one gains less than a square of its area: at 1 cm on skin five of 1:1 to 1:1300 gained 4.5
 * times the root of that, within a factor of 1.6. */
static double spread_of(const struct cml_detector_def *detector)
{
    const double *size = detector->size, narrow = fmin(size[0], size[1]) / fmax(size[0], size[1]);
    return detector->shape == CML_DETECTOR_RING ? 1 : fmin(1, 4.5 * sqrt(narrow));
}

/* The part of its aperture in light that leaves evenly bright in all directions, as it does where it was
 * scattered: 1 to 1.15 times as much was counted on rough skin. */
double cml_accepted_by(const struct cml_scene *scene, const struct cml_detector_def *detector)
{
    const double n = scene->media[detector->below ? scene->num_layers + 1 : 0].n,
                 sine = fmin(1, detector->na / n);
    return detector->aimed ? sine * sine * fmax(cos(detector->angle), sine / 5) : 1;
}

/* A plain packet has V = weight / (worth accepted), `weight` what packets weigh that arrive, by weight. Of
 * one in windows `most` / 3 parts arrive, of families that part late, so that each goes into the aperture by
 * its own luck, in a time that grows with every decade. The numbers are fitted to six fibres of 0.01 to 0.05
 * cm at 0.15 to 1 cm on rough skin, each without an aperture and with 0.5 and 0.22, within a factor of 1.8;
 * with seven others it was within 2.4. */
double cml_gain_at(const struct cml_detector_def *detector, const struct cml_window_table *windows,
                   double weight, double most)
{
    const double plain = weight / (windows->worth * windows->accepted),
                 aimed = (3.5 + 3 / windows->accepted) / most, longer = fmax(0.8, -log(windows->worth) / 6),
                 gain = spread_of(detector) * plain / aimed / longer;
    if (windows->share < 1) return fmax(1, gain) / windows->share;
    return gain < 1 ? 0 : gain;
}
