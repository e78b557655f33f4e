/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "optics_cases.h"
