/* Runs the cases of cone_random_cases.h in double precision. SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/cone_random_cases.h"
