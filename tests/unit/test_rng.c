/* SPDX-License-Identifier: MIT */
#include "rng_cases.h"
