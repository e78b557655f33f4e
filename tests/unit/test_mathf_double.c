/* SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "mathf_cases.h"
