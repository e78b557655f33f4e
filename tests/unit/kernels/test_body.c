/* Runs the cases of body_cases.h in single precision. SPDX-License-Identifier: MIT */
#include "unit/kernels/body_cases.h"
