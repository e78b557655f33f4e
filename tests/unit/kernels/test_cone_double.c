/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/cone_cases.h"
