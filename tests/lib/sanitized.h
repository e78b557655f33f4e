/* The number of random cases of a test that are run: all if the environment has ALL_CASES (ctest -L long),
 * else one in eight.
 *
 * A build with sanitizers checks addresses and undefined operations and takes ten times as long. It runs one
 * case in sixteen, and skips, by SANITIZED, tests that need all cases. Every kind of case, shape and mesh is
 * always run.
 * SPDX-License-Identifier: MIT */
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

/* Returns the step between cases that are run. */
static inline int cases_step(void)
{
    return SANITIZED ? SANITIZED_STEP : getenv("ALL_CASES") ? 1 : 8;
}

/* Returns the number of cases that are run out of `all`. */
static inline int repeats(int all)
{
    return all / cases_step();
}
