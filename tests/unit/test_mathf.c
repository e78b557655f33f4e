/* SPDX-License-Identifier: MIT */
#include "mathf_cases.h"
