/* Mathematical constants. SPDX-License-Identifier: MIT */
#pragma once

#define CML_PI 3.14159265358979323846 /* C11 does not promise M_PI */
