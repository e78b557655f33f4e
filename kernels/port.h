/* The differences between C and OpenCL C: names of integers, address spaces, names of mathematical functions.
 * Every other header in this folder is plain C that both compilers read. `real` is float, or double in a file
 * that defines CML_DOUBLE before it includes these headers: the same physics in two precisions, one per
 * translation unit.
 * SPDX-License-Identifier: MIT */
#pragma once

#ifdef __OPENCL_VERSION__
#pragma OPENCL FP_CONTRACT OFF
typedef uint cml_u32;
typedef ulong cml_u64;
#define CML_GLOBAL __global
/* Address space of the rarely used members of packets. A device with one lane keeps them out of its
 * registers. */
#if CML_DEVICE_LANES > 1
#define CML_PACKET __private
#else
#define CML_PACKET __global
#endif
/* Inlined, because lanes must live in registers. */
#define CML_FN static inline __attribute__((always_inline))
#define CML_RARE CML_FN
#define CML_SQRT sqrt
#define CML_FMA fma
#define CML_FABS fabs
#define CML_FLOOR floor
#define CML_COPYSIGN copysign
#define CML_CLZ(n) clz((uint)(n))
#define CML_MAY_HAVE_MESHES 0 /* the host refuses meshes for devices */
#else
#include <math.h>
#include <stdint.h>
#include <string.h>
typedef uint32_t cml_u32;
typedef uint64_t cml_u64;
#define CML_GLOBAL
#define CML_PACKET
#define CML_CLZ(n) __builtin_clz((unsigned)(n))
#define CML_MAY_HAVE_MESHES 1
#define CML_FN static inline
#define CML_RARE static __attribute__((noinline, unused)) /* not inlined, so that its callers stay short */
#endif

/* States an invariant. Host builds without NDEBUG (Debug, sanitizers) check it; release builds and devices do
 * not even compute it. */
#if defined(__OPENCL_VERSION__) || defined(NDEBUG)
#define CML_ASSERT(condition) ((void)0)
#else
#include <assert.h>
#define CML_ASSERT(condition) assert(condition)
#endif

/* Multiply-adds are written out as CML_FMA, with one rounding each, and compilers contract nothing by
 * themselves. So every compiler, vector width and device gives the same bits. */
#ifdef CML_DOUBLE
typedef double real;
#define CML_SQRT sqrt
#define CML_FMA fma
#define CML_FABS fabs
#define CML_FLOOR floor
#define CML_COPYSIGN copysign
#else
typedef float real;
#ifndef __OPENCL_VERSION__
#define CML_SQRT sqrtf
#define CML_FMA fmaf
#define CML_FABS fabsf
#define CML_FLOOR floorf
#define CML_COPYSIGN copysignf
#endif
#endif

/* Features that a scene may lack. A device's compiler is told which, so that it leaves their code out. */
#ifdef CML_ONLY_PLANES
#define CML_ALL_PLANES 1
#else
#define CML_ALL_PLANES 0
#endif
#ifdef CML_WITHOUT_BODIES
#define CML_MAY_HAVE_BODIES 0
#else
#define CML_MAY_HAVE_BODIES 1
#endif
#ifdef CML_WITHOUT_PHASES /* the scene has no phase table */
#define CML_MAY_HAVE_PHASES 0
#else
#define CML_MAY_HAVE_PHASES 1
#endif

#ifdef CML_WITHOUT_ROUGHNESS
#define CML_MAY_BE_ROUGH 0
#else
#define CML_MAY_BE_ROUGH 1
#endif

/* The spacing of `real` at 1. */
#ifdef CML_DOUBLE
#define CML_EPSILON ((real)2.220446049250313e-16)
#else
#define CML_EPSILON ((real)1.1920928955078125e-7)
#endif

#define CML_INFINITY ((real)INFINITY)

struct cml_vec {
    real x, y, z;
};
