/* SPDX-License-Identifier: MIT */
#include "unit/kernels/cone_random_cases.h"
