/* SPDX-License-Identifier: MIT */
#ifndef CML_CONSTANTS_H
#define CML_CONSTANTS_H

#define CML_PI 3.14159265358979323846 /* C11 does not promise M_PI */

#endif
