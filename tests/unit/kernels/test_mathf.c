/* Runs the cases of mathf_cases.h in single precision. SPDX-License-Identifier: MIT */
#include "unit/kernels/mathf_cases.h"
