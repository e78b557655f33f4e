/* SPDX-License-Identifier: MIT */
#include "unit/kernels/optics_cases.h"
