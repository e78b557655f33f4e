/* SPDX-License-Identifier: MIT */
#include "unit/kernels/rng_cases.h"
