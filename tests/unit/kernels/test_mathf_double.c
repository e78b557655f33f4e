/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/mathf_cases.h"
