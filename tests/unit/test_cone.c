/* SPDX-License-Identifier: MIT */
#include "cone_cases.h"
