/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "cone_cases.h"
