/* SPDX-License-Identifier: MIT */
#include "optics_cases.h"
