/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/rough_cases.h"
