/* Runs the cases of rough_cases.h in single precision. SPDX-License-Identifier: MIT */
#include "unit/kernels/rough_cases.h"
