/* The clock of the benches that fly on one thread. SPDX-License-Identifier: MIT */
#pragma once

#include <time.h>

/* Returns the seconds that a processor has worked for this thread. Other work on the machine does not count.
 */
static double thread_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
