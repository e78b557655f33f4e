/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "rng_cases.h"
