/* Runs the cases of cone_random_cases.h in single precision. SPDX-License-Identifier: MIT */
#include "unit/kernels/cone_random_cases.h"
