/* Runs the cases of rng_cases.h in double precision. SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/rng_cases.h"
