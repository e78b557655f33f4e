/* SPDX-License-Identifier: MIT */
#include "unit/kernels/mathf_cases.h"
