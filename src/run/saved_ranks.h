/* Saved packets of all ranks. SPDX-License-Identifier: MIT */
#pragma once

#include "tally/saved.h"

/* What ranks have saved becomes rank 0's, and that of the others is empty; NULL: nothing is saved.
 * Collective. */
CML_NODISCARD cml_status cml_gather_saved(struct cml_saved *saved, struct cml_error *err);
