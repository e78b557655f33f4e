/* What only .h5 files hold, compared. SPDX-License-Identifier: MIT */
#pragma once

#include "plot/compare_groups.h"

/* Tests what both files hold beside their outcomes, if they are .h5 files: maps, voxels, facets, pixels of
 * detectors. CML_E_INPUT. */
CML_NODISCARD cml_status cml_compare_arrays(const struct cml_outcome *const outcome[2],
                                            const char *const names[2], struct cml_comparison *c,
                                            struct cml_error *err);
