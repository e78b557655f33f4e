/* The gain of weight windows, estimated before any photon is simulated: the time of a plain run over the time
 * of a run with windows, for the same error. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/window_table.h"
#include "scene/scene.h"

/* Returns the power p of the rule for windows: weights of packets are proportional to the importance of their
 * place to the power -p. worth: share of the light that reaches the target. */
double cml_windows_power(double worth);

/* Returns the gain for light that leaves below the layers; 0 if windows gain nothing. */
double cml_gain_below(double worth);

/* Returns the share of the light at a detector that its aperture accepts, 0 to 1. */
double cml_accepted_by(const struct cml_scene *scene, const struct cml_detector_def *detector);

/* Returns the gain for light at a detector; 0 if windows gain nothing. weight: mean weight, weighted by
 * weight, of plain packets that reach the detector. most: the largest importance of any place. */
double cml_gain_at(const struct cml_detector_def *detector, const struct cml_window_table *windows,
                   double weight, double most);
