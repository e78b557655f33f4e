/* clustermcml run --sweep: one run for each row of a table. SPDX-License-Identifier: MIT */
#pragma once

#include "base/input_files.h"
#include "cli/options/options.h"
#include "output/report.h"
#include "scene/scene.h"

/* Validates all rows of options->sweep before the first one flies, flies them and writes the tables of their
 * totals. list: the scene without them, of one run; inputs: the files that it was read from, the table last.
 * A row's result has the bytes of a run with --set of its cells. Several ranks fly a row together where there
 * are no more rows than ranks; else each flies rows by itself, the next when it has done one. Collective.
 * CML_E_NUMERIC: all is written, and the result of a row is not to be trusted. */
CML_NODISCARD cml_status cml_sweep(const struct cml_options *options, const struct cml_scene_list *list,
                                   struct cml_inputs *inputs, struct cml_error *err);

/* What check says of a sweep; *size is zeroed where there is none. *largest: what the flight of rows that
 * takes most memory asks of the engine, but for `rows.more`; as it was where no rows fly together.
 * CML_E_INPUT where options cannot stand together, or the table or one of its rows is wrong. The first three
 * are as in cml_sweep. */
CML_NODISCARD cml_status cml_sweep_check(const struct cml_options *options, const struct cml_scene_list *list,
                                         struct cml_inputs *inputs, struct cml_sweep_size *size,
                                         struct cml_engine_options *largest, struct cml_error *err);
