/* How the values of options are read. Every message names the option, what was given, and what was expected.
 * Functions with the signature of cml_option.read. SPDX-License-Identifier: MIT */
#pragma once

#include "cli/options/option.h"
#include "cli/options/options.h"

typedef cml_status cml_option_reader(const struct cml_option *option, const char *value,
                                     struct cml_options *options, struct cml_error *err);

/* Shared: they set option->member, of option->size. A flag sets it to option->least; a text is the value, of
 * once given but once; numbers lie between option->least and most, and whole ones may be written like 1e7; a
 * word becomes its position among option->words, from option->least on. */
cml_option_reader cml_read_flag, cml_read_text, cml_read_count, cml_read_int, cml_read_number, cml_read_word;

/* Each reads the value of one option. */
cml_option_reader cml_read_engine, cml_read_roulette, cml_read_aim, cml_read_error_of, cml_read_checkpoint,
    cml_read_part, cml_read_tolerance, cml_read_mesh_budget, cml_read_set, cml_read_seed;
