/* Reads options by their names. SPDX-License-Identifier: MIT */
#pragma once

#include "options/option.h"
#include "options/options.h"

/* Sets the defaults of all options. */
void cml_options_default(struct cml_options *options);

/* Reads one option, unless it is refused: an option of other commands or engines, without its value, or with
 * a value that it does not take (surplus). typed: the option as the user wrote it, for messages. */
CML_NODISCARD cml_status cml_option_read(const struct cml_option *option, const char *typed,
                                         const char *value, bool surplus, struct cml_options *options,
                                         struct cml_error *err);

/* Reads words NAME or NAME=VALUE, which NULL ends. All names are those of options. Values are borrowed. */
CML_NODISCARD cml_status cml_options_read(const char *const *words, struct cml_options *options,
                                          struct cml_error *err);
