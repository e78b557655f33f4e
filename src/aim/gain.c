/* Formulas for the gain of weight windows (P19): how much less time a run with windows takes to the same
 * error. Their numbers are fitted to runs with and without windows. bench/choices/aim.py repeats those runs;
 * its table has each measured gain beside the gain from these formulas. SPDX-License-Identifier: MIT */
#include "aim/gain.h"

#include <math.h>

/* Windows gain little, and slow down the light that is reflected, where much light arrives. */
double cml_windows_power(double worth)
{
    return worth > 1e-2 ? 0.5 : worth > 1e-5 ? 0.75 : 0.9;
}

/* V, the variance of one packet divided by the square of its mean, is 0.008 / worth without windows, because
 * packets weigh little there, and about log(V)^2 with windows. Windows gain nothing where more than 5e-3 of
 * the light arrives. */
double cml_gain_below(double worth)
{
    /* V / log(V)^2 is smallest at V = e^2 = 7.4. For smaller V the formula would rise again, so the gain is 2
     * there. */
    const double V = 0.008 / worth, least = 7.4;
    if (!(worth < 5e-3)) return 0;
    return V > least ? V / pow(log(V), 2) : 2;
}

/* Returns the share of a detector's gain that remains because the detector extends around the aim. A
 * rectangle's windows aim at its middle, so a narrow rectangle gains less than a square of the same area. At
 * 1 cm on skin, five rectangles of 1:1 to 1:1300 gained 4.5 times the root of narrow side over long side,
 * within a factor of 1.6. */
static double spread_of(const struct cml_detector_def *detector)
{
    const double *size = detector->size, narrow = fmin(size[0], size[1]) / fmax(size[0], size[1]);
    const bool whole = cml_detector_is_round(detector) || detector->shape == CML_DETECTOR_GROUP;
    return whole ? 1 : fmin(1, 4.5 * sqrt(narrow));
}

/* The light is taken to leave equally bright in all directions, as scattered light does. On rough skin 1 to
 * 1.15 times that share was counted. */
double cml_accepted_by(const struct cml_scene *scene, const struct cml_detector_def *detector)
{
    const double n = detector->contact ? scene->contacts[detector->contact - 1].n
                                       : scene->media[detector->below ? scene->num_layers + 1 : 0].n,
                 sine = fmin(1, detector->na / n);
    return detector->aimed ? sine * sine * fmax(cos(detector->angle), sine / 5) : 1;
}

/* A plain packet has the relative variance weight / (worth accepted). With windows, a packet arrives in about
 * most parts, and splits by the root of `accepted` before the aperture. The time grows with every decade of
 * the worth and with these last parts. The numbers are fitted to sixteen detectors, within a factor of 2.4:
 * the fibres of bench/choices/aim.py, ports of 0.01 and 0.03 cm at 0.02 to 0.3 cm, alone and six in a group,
 * and rings of 0.2 cm with apertures down to 0.01. */
double cml_gain_at(const struct cml_detector_def *detector, const struct cml_window_table *windows,
                   double weight, double most)
{
    const double plain = weight / (windows->worth * windows->accepted), narrow = sqrt(windows->accepted),
                 longer = fmax(0.8, -log(windows->worth) / 6) * (1 + 2 * most / narrow),
                 gain = spread_of(detector) * plain * most * narrow / 2.4 / longer;
    if (windows->share < 1) return fmax(1, gain) / windows->share;
    return gain < 1 ? 0 : gain;
}
