/* Runs the cases of rough_cases.h in double precision. SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/rough_cases.h"
