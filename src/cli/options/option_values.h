/* How the values of options are read. Every message names the option, what was given, and what was expected.
 * Functions with the signature of cml_option.read. SPDX-License-Identifier: MIT */
#pragma once

#include "cli/options/option.h"
#include "cli/options/options.h"

typedef cml_status cml_option_reader(const struct cml_option *option, const char *value,
                                     struct cml_options *options, struct cml_error *err);

/* Shared: they set option->member. A bool becomes true or false; a text is the value, of once given but once;
 * numbers lie between option->least and most, and whole ones may be written like 1e7; a range is A:B. */
cml_option_reader cml_read_true, cml_read_false, cml_read_text, cml_read_once, cml_read_count, cml_read_int,
    cml_read_seconds, cml_read_range;

/* Each reads the value of one option. */
cml_option_reader cml_read_engine, cml_read_sampling, cml_read_roulette, cml_read_control, cml_read_aim,
    cml_read_target_error, cml_read_error_of, cml_read_checkpoint, cml_read_boundaries, cml_read_tolerance,
    cml_read_mesh_budget, cml_read_normals, cml_read_rings, cml_read_mesh_search, cml_read_alpha,
    cml_read_cut, cml_read_log, cml_read_linear, cml_read_percentile, cml_read_label, cml_read_set,
    cml_read_seed;
