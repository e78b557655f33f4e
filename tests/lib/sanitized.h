/* How many of the random cases of a test are flown: all of them where the environment has ALL_CASES (ctest -L
 * long), else one in eight, and one in sixteen by a build with sanitizers, which looks at addresses and
 * undefined operations, takes ten times as long, and skips by SANITIZED what needs all. Every kind of case,
 * shape and mesh is always there. SPDX-License-Identifier: MIT */
#pragma once

#include <stdlib.h>

#ifndef __has_feature
#define __has_feature(name) 0
#endif
#if defined __SANITIZE_ADDRESS__ || __has_feature(address_sanitizer)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

enum { SANITIZED_STEP = SANITIZED ? 16 : 1 };

/* One in so many is flown. */
static inline int cases_step(void)
{
    return SANITIZED ? SANITIZED_STEP : getenv("ALL_CASES") ? 1 : 8;
}

/* The number of cases, of which there are `all`. */
static inline int repeats(int all)
{
    return all / cases_step();
}
