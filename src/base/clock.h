/* Wall time, and a thread's own. Only how long something took may follow from it, never a result.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <time.h>

/* Seconds since some moment in the past, from a clock that nobody sets back. */
static inline double cml_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Processor time that the calling thread has had, s. */
static inline double cml_thread_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
