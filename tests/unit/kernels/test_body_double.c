/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/body_cases.h"
