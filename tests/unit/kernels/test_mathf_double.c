/* Runs the cases of mathf_cases.h in double precision. SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/mathf_cases.h"
