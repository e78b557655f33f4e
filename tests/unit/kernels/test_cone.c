/* Runs the cases of cone_cases.h in single precision. SPDX-License-Identifier: MIT */
#include "unit/kernels/cone_cases.h"
