/* Runs the cases of optics_cases.h in double precision. SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/optics_cases.h"
