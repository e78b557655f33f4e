/* How much less time windows take to the same error than plain flights, before anything is flown.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/window_table.h"
#include "scene/scene.h"

/* How windows follow what light is worth: weights go as its inverse to this power. worth: of what is wanted,
 * the share of the light that gets there. */
double cml_windows_power(double worth);

/* The gain for light that comes out below; 0: nothing. */
double cml_gain_below(double worth);

/* The share of the light at a detector that its aperture takes. */
double cml_accepted_by(const struct cml_scene *scene, const struct cml_detector_def *detector);

/* The gain for what a detector sees; 0: nothing. weight: the mean weight, by weight, of plain packets that
 * come to it; most: the largest worth of a place. */
double cml_gain_at(const struct cml_detector_def *detector, const struct cml_window_table *windows,
                   double weight, double most);
