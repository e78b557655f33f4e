/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/rng_cases.h"
