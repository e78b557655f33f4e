/* Runs the cases of body_cases.h in double precision. SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/body_cases.h"
