/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "unit/kernels/optics_cases.h"
