/* SPDX-License-Identifier: MIT */
#include "unit/kernels/rough_cases.h"
