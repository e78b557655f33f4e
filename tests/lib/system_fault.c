/* A preloaded library with clocks that jump, a system that starts no threads, and file systems without
 * locks. Variables:
 *
 * CML_CLOCK=tick: the monotonic clock advances by one second at every look. Events that depend on time then
 * depend on the work done, and not on the machine.
 *
 * CML_CLOCK="jump SECONDS": the date jumps by so many seconds at every tenth look, forwards first, then
 * back, and so on. CML_CLOCK_LOG: a file to which a line is appended at every jump.
 *
 * CML_THREADS=N: the N-th thread and all later ones that the program itself starts (not its libraries) are
 * refused with EAGAIN. With 0, all threads are refused, those of libraries, too.
 *
 * CML_LOCKS=ERRNO: every lock of a file is refused with this errno.
 *
 * SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/file.h>
#include <sys/time.h>
#include <time.h>

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

/* Returns the error of the date at this look [s]. */
static long jump(void)
{
    static atomic_int looks;
    long seconds = 0;
    const char *text = getenv("CML_CLOCK"), *log = getenv("CML_CLOCK_LOG");
    if (!text || sscanf(text, "jump %ld", &seconds) != 1) return 0;
    const int look = atomic_fetch_add(&looks, 1);
    FILE *file = look % 10 == 0 && log ? fopen(log, "a") : NULL;
    if (file) fprintf(file, "jump\n"), fclose(file);
    return look / 10 % 2 == 0 ? seconds : 0;
}

static int real_clock(clockid_t clock, struct timespec *time)
{
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = REAL(clock_gettime);
    return real(clock, time);
}

int clock_gettime(clockid_t clock, struct timespec *time)
{
    static atomic_int looks;
    const char *text = getenv("CML_CLOCK");
    const int failed = real_clock(clock, time);
    if (clock == CLOCK_MONOTONIC && text && strcmp(text, "tick") == 0)
        time->tv_sec += atomic_fetch_add(&looks, 1);
    if (clock == CLOCK_REALTIME) time->tv_sec += jump();
    return failed;
}

int gettimeofday(struct timeval *restrict time, void *restrict zone)
{
    (void)zone;
    struct timespec now;
    const int failed = real_clock(CLOCK_REALTIME, &now);
    time->tv_sec = now.tv_sec + jump();
    time->tv_usec = (suseconds_t)(now.tv_nsec / 1000);
    return failed;
}

time_t time(time_t *result)
{
    struct timespec now;
    real_clock(CLOCK_REALTIME, &now);
    now.tv_sec += jump();
    if (result) *result = now.tv_sec;
    return now.tv_sec;
}

static int is_program(const void *address)
{
    Dl_info caller, program;
    const void *head = (const void *)getauxval(AT_PHDR);
    return dladdr(address, &caller) && dladdr(head, &program) && caller.dli_fbase == program.dli_fbase;
}

int pthread_create(pthread_t *id, const pthread_attr_t *attributes, void *(*body)(void *), void *argument)
{
    static atomic_int threads;
    const char *first = getenv("CML_THREADS");
    if (first && atoi(first) == 0) return EAGAIN;
    if (first && is_program(__builtin_return_address(0)) && atomic_fetch_add(&threads, 1) + 1 >= atoi(first))
        return EAGAIN;
    return REAL(pthread_create)(id, attributes, body, argument);
}

static int refuses_locks(void)
{
    const char *reason = getenv("CML_LOCKS");
    if (!reason) return 0;
    errno = atoi(reason);
    return 1;
}

int flock(int file, int operation)
{
    return refuses_locks() ? -1 : REAL(flock)(file, operation);
}

static int is_lock(int command)
{
    return command == F_SETLK || command == F_SETLKW || command == F_OFD_SETLK || command == F_OFD_SETLKW;
}

#define FCNTL(name)                                                                                          \
    int name(int file, int command, ...)                                                                     \
    {                                                                                                        \
        va_list rest;                                                                                        \
        va_start(rest, command);                                                                             \
        void *argument = va_arg(rest, void *);                                                               \
        va_end(rest);                                                                                        \
        return is_lock(command) && refuses_locks() ? -1 : REAL(name)(file, command, argument);               \
    }
FCNTL(fcntl)
FCNTL(fcntl64)
