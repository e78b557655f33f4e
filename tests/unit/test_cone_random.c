/* SPDX-License-Identifier: MIT */
#include "cone_random_cases.h"
