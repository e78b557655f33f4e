/* SPDX-License-Identifier: MIT */
#include "unit/kernels/cone_cases.h"
