/* clustermcml run --sweep: one run for each row of a table. SPDX-License-Identifier: MIT */
#pragma once

#include "base/input_files.h"
#include "options/options.h"
#include "output/report.h"
#include "scene/scene.h"

/* Checks all rows of options->sweep before the first one flies, flies them, and writes the tables of their
 * totals. list: one run, the scene before its numbers are set. inputs: the files that it was read from, the
 * table last. The result of a row has the same bytes as a run with --set of its cells. If there are more rows
 * than ranks, each rank flies rows by itself, one after the other; else all ranks fly each row together.
 * With options->receiver nothing is written.
 * Collective. CML_E_NUMERIC: all is written, but the result of a row cannot be trusted. */
CML_NODISCARD cml_status cml_sweep(const struct cml_options *options, const struct cml_scene_list *list,
                                   struct cml_inputs *inputs, struct cml_error *err);

/* Checks a sweep and returns its size, zero without --sweep. *largest: the engine options of the flight of
 * rows that takes most memory, without `rows.more`; unchanged if no rows share a flight. options, list and
 * inputs as in cml_sweep. CML_E_INPUT: options that contradict each other, or an invalid table or row. */
CML_NODISCARD cml_status cml_sweep_check(const struct cml_options *options, const struct cml_scene_list *list,
                                         struct cml_inputs *inputs, struct cml_sweep_size *size,
                                         struct cml_engine_options *largest, struct cml_error *err);
