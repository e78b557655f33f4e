/* Flights that several rows of a sweep share, because they differ only in absorption (--reweight).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "flights/sweep_scenes.h"

/* Refuses options beside --reweight that rows of one flight do not support: they share photons. CML_E_INPUT.
 */
CML_NODISCARD cml_status cml_sweep_check_options(const struct cml_options *options, struct cml_error *err);

/* Refuses a scene that asks for results which rows of one flight cannot have. CML_E_INPUT. */
CML_NODISCARD cml_status cml_sweep_check_reweighted(const struct cml_scene *scene, struct cml_error *err);

/* Checks the memory of all flights: CML_E_INPUT if one needs more than the machine has. *largest: the engine
 * options of the flight that needs most, with `rows.more` NULL. */
CML_NODISCARD cml_status cml_sweep_check_groups(const struct cml_sweep_run *sweep,
                                                struct cml_engine_options *largest, struct cml_error *err);

/* Flies all groups, one after the other, each on all ranks. Ends as cml_sweep_rows_fly does. Collective. */
CML_NODISCARD cml_status cml_sweep_fly_groups(struct cml_sweep_run *sweep, struct cml_error *err);
