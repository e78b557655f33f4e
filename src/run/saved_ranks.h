/* Brings the saved packets of all ranks together. SPDX-License-Identifier: MIT */
#pragma once

#include "tally/saved.h"

/* Moves the saved packets of all ranks to rank 0 and empties those of the others. saved NULL: nothing is
 * saved. Collective. */
CML_NODISCARD cml_status cml_gather_saved(struct cml_saved *saved, struct cml_error *err);
