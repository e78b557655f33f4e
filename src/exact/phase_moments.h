/* Legendre moments of a medium's phase function. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "scene/scene.h"

/* Sets moment[l], 0 <= l < count, to the mean of P_l over the cosine of deflection. This is g^l for Henyey
 * and Greenstein's function; for others the error is below 1e-9. CML_E_INPUT: out of memory. */
CML_NODISCARD cml_status cml_phase_moments(const struct cml_medium_def *medium, int count, double *moment,
                                           struct cml_error *err);
