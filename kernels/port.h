/* What C and OpenCL C do not share: integer names, address spaces, the maths functions' names.
 * Every other header here is plain C that both compilers read. `real` is float unless CML_DOUBLE is defined
 * by the file that includes us: the same physics in two precisions, one per translation unit.
 * SPDX-License-Identifier: MIT */
#ifndef CML_PORT_H
#define CML_PORT_H

#ifdef __OPENCL_VERSION__
#pragma OPENCL FP_CONTRACT OFF
typedef uint cml_u32;
typedef ulong cml_u64;
#define CML_GLOBAL __global
#define CML_SQRTF sqrt
#define CML_ACOSF acos
#else
#include <math.h>
#include <stdint.h>
#include <string.h>
typedef uint32_t cml_u32;
typedef uint64_t cml_u64;
#define CML_GLOBAL
#define CML_SQRTF sqrtf
#define CML_ACOSF acosf
#endif

#define CML_FN static inline

#ifdef CML_DOUBLE
typedef double real;
#define CML_SQRT sqrt
#define CML_ACOS acos
#else
typedef float real;
#define CML_SQRT CML_SQRTF
#define CML_ACOS CML_ACOSF
#endif

/* Spacing of real at 1. */
#ifdef CML_DOUBLE
#define CML_EPSILON ((real)2.220446049250313e-16)
#else
#define CML_EPSILON ((real)1.1920928955078125e-7)
#endif

#define CML_INFINITY ((real)INFINITY)

struct cml_vec {
    real x, y, z;
};

#endif
