/* Commands that the Python package does: plot, compare, view, brdf, profile. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

/* Becomes Python with these words. The package is the one beside the program: in a build tree, an install
 * tree, a wheel; else the one that Python finds. The environment's CLUSTERMCML_PYTHON names the interpreter,
 * else it is python3. Returns only where that cannot be started: CML_E_IO. */
CML_NODISCARD cml_status cml_hand_over(int argc, char **argv, struct cml_error *err);
