/* Makes one request for memory fail. The program is linked with --wrap for malloc, calloc and realloc, so
 * that only its own requests count, and none of its libraries.
 *
 * FAIL_ALLOCATION=N lets the N-th request fail (from 1), and no other. FAIL_ALLOCATION=0 lets none fail, and
 * prints their number when the program ends.
 * SPDX-License-Identifier: MIT */
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *block, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *block, size_t size);

static atomic_long requests;
static long failing;

__attribute__((constructor)) static void begin(void)
{
    const char *number = getenv("FAIL_ALLOCATION");
    failing = number ? atol(number) : 0;
}

__attribute__((destructor)) static void end(void)
{
    if (failing == 0) fprintf(stderr, "requests: %ld\n", atomic_load(&requests));
}

static int fails(void)
{
    return atomic_fetch_add(&requests, 1) + 1 == failing;
}

void *__wrap_malloc(size_t size)
{
    return fails() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return fails() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *block, size_t size)
{
    return fails() ? NULL : __real_realloc(block, size);
}
