/* Runs the cases of rng_cases.h in single precision. SPDX-License-Identifier: MIT */
#include "unit/kernels/rng_cases.h"
