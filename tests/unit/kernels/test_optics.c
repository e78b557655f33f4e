/* Runs the cases of optics_cases.h in single precision. SPDX-License-Identifier: MIT */
#include "unit/kernels/optics_cases.h"
