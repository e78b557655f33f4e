/* Rows of a sweep that differ in absorption alone, from one flight (--reweight). SPDX-License-Identifier: MIT
 */
#pragma once

#include "cli/run/sweep_scenes.h"

/* CML_E_INPUT where options stand beside --reweight that rows of one flight are not made for. */
CML_NODISCARD cml_status cml_sweep_check_options(const struct cml_options *options, struct cml_error *err);

/* CML_E_INPUT where the scene asks for what rows of one flight have not. */
CML_NODISCARD cml_status cml_sweep_check_reweighted(const struct cml_scene *scene, struct cml_error *err);

/* CML_E_INPUT where one of the flights takes more memory than the machine has. *largest: what the one that
 * takes most asks of the engine, but for `rows.more`, which is NULL. */
CML_NODISCARD cml_status cml_sweep_check_groups(const struct cml_sweep_run *sweep,
                                                struct cml_engine_options *largest, struct cml_error *err);

/* Flies all groups, one after the other on all ranks. Ends as cml_sweep_rows_fly does. Collective. */
CML_NODISCARD cml_status cml_sweep_fly_groups(struct cml_sweep_run *sweep, struct cml_error *err);
