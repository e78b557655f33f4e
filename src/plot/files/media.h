/* Which medium absorbs in a bin of a result, as far as its file says: layers by their thicknesses, curved
 * boundaries and bodies by the depths and radii that their lines name. SPDX-License-Identifier: MIT */
#pragma once

#include "result/outcome.h"

/* mua in every bin of depth, 1/cm: *mua[nz], or with by_radius [nz][nr], the caller's to free. 0 where
 * nothing absorbs, as outside of all layers; NAN where a bin holds two media of different mua, or may do so:
 * between the highest and the lowest point of a curved boundary, and in the box around a body. CML_E_INPUT
 * where a file has such shapes and does not say where they lie, and when memory runs out. */
CML_NODISCARD cml_status cml_media_mua(const struct cml_outcome *outcome, const char *path, bool by_radius,
                                       double **mua, struct cml_error *err);
