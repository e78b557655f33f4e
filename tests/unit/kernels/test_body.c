/* SPDX-License-Identifier: MIT */
#include "unit/kernels/body_cases.h"
