/* Hands commands over to the Python package: plot, compare, view, brdf, profile. SPDX-License-Identifier: MIT
 */
#pragma once

#include "base/status.h"

/* Replaces the process by Python with these words. The package beside the program (build tree, install tree,
 * wheel) is used, else the one that Python finds. The environment variable CLUSTERMCML_PYTHON names the
 * interpreter; default python3. Returns only if the interpreter cannot be started: CML_E_IO. */
CML_NODISCARD cml_status cml_hand_over(int argc, char **argv, struct cml_error *err);
