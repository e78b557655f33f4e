/* SPDX-License-Identifier: MIT */
#include "run/stop.h"

#include "base/clock.h"
#include "base/status.h"
#include "base/text.h"

#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <unistd.h>

/* Written by a signal handler, which any thread may be interrupted for, and read by all threads between two
 * pieces: such an object must be atomic, and without a lock (C11, 5.1.2.3 and 7.14.1.1). */
static atomic_int flying;
static atomic_llong requested; /* when, ms */
_Static_assert(ATOMIC_INT_LOCK_FREE == 2 && ATOMIC_LLONG_LOCK_FREE == 2,
               "a signal handler cannot wait for a lock");

/* A signal that comes more than a second after the first ends the process as if it had not been caught: exit
 * code 128 + number, as shells report it. _exit, because exit is not safe in a handler; clock_gettime is.
 * Sooner it is the same wish: launchers and batch systems send one to the process and once more to its group.
 * Ctrl-C is no exception: a run that was asked to stop does so within a second, and hours of it are worth
 * more than a third press of the key. */
static void remember(int signal)
{
    static const char early[] = "clustermcml: stopped before the flight: nothing was written\n";
    if (!atomic_load(&flying)) {
        (void)!write(STDERR_FILENO, early, sizeof early - 1);
        _exit(CML_E_STOPPED);
    }
    const long long now = (long long)(1e3 * cml_now());
    long long first = 0;
    if (!atomic_compare_exchange_strong(&requested, &first, now) && now - first > 1000) _exit(128 + signal);
}

void cml_stop_ignore(void)
{
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
}

void cml_stop_without_reader(void)
{
    signal(SIGPIPE, SIG_DFL);
    raise(SIGPIPE);
}

/* A parent that ended before prctl sends no signal. */
void cml_stop_with_parent(void)
{
    const char *text = getenv("CLUSTERMCML_PARENT");
    int parent = 0;
    if (!text || !cml_parse_int(text, &parent) || getppid() != parent) return;
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) raise(SIGTERM);
}

/* SA_RESTART: file and MPI calls that are under way must not fail for a signal that is only remembered.
 * nohup and the like set signals to be ignored, and mean it. */
void cml_stop_before_flight(void)
{
    static const int signals[] = {SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU};
    struct sigaction action = {.sa_handler = remember, .sa_flags = SA_RESTART}, old;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
        sigaction(signals[i], NULL, &old);
        if (old.sa_handler != SIG_IGN) sigaction(signals[i], &action, NULL);
    }
}

void cml_stop_watch(void)
{
    atomic_store(&flying, 1);
}

bool cml_stop_requested(void)
{
    return atomic_load(&requested) != 0;
}
