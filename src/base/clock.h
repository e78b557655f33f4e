/* Wall time and processor time. Results must never depend on either; only reports of how long something took
 * do. SPDX-License-Identifier: MIT */
#pragma once

#include <time.h>

/* Returns seconds since some fixed moment in the past, from a clock that nobody sets back. */
static inline double cml_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Returns the processor time of the calling thread, s. */
static inline double cml_thread_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
