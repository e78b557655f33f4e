/* Functions that read the values of options (cml_option.read). Every message names the option, its value, and
 * the expected value. SPDX-License-Identifier: MIT */
#pragma once

#include "options/option.h"
#include "options/options.h"

typedef cml_status cml_option_reader(const struct cml_option *option, const char *value,
                                     struct cml_options *options, struct cml_error *err);

/* Read a value into option->member, of size option->size. A flag becomes option->least. A text is borrowed.
 * Numbers must lie between option->least and option->most; whole numbers may be written like 1e7. A word
 * becomes its position among option->words, counted from option->least. */
cml_option_reader cml_read_flag, cml_read_text, cml_read_count, cml_read_int, cml_read_number, cml_read_word;

/* Read the value of one option each. */
cml_option_reader cml_read_engine, cml_read_roulette, cml_read_aim, cml_read_error_of, cml_read_checkpoint,
    cml_read_part, cml_read_tolerance, cml_read_mesh_budget, cml_read_set, cml_read_seed;
