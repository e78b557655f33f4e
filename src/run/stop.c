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

/* True while photons fly. `flying` and `requested` are written by a signal handler, which may interrupt any
 * thread, and read by all threads between two pieces: they must be atomic and lock-free (C11, 5.1.2.3 and
 * 7.14.1.1). */
static atomic_int flying;
static atomic_llong requested; /* time of the first signal, ms; 0: none */
_Static_assert(ATOMIC_INT_LOCK_FREE == 2 && ATOMIC_LLONG_LOCK_FREE == 2,
               "a signal handler cannot wait for a lock");

/* Remembers a signal (the signal handler). A signal more than a second after the first ends the process at
 * once, with exit code 128 + number as shells report it. An earlier one is the same wish: launchers send a
 * signal to the process and to its group. _exit and clock_gettime are safe in a handler; exit is not. */
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

/* Lets writing to a closed pipe or beyond a limit of file sizes fail with an error, instead of killing the
 * process. */
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

/* Makes this process end with its parent (Linux). The parent is tested again afterwards: no signal comes
 * from a parent that ended before. */
void cml_stop_with_parent(void)
{
    const char *text = getenv("CLUSTERMCML_PARENT");
    int parent = 0;
    if (!text || !cml_parse_int(text, &parent) || getppid() != parent) return;
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) raise(SIGTERM);
}

/* Makes the program remember signals that ask it to end, so that a run can write its checkpoint first.
 * SA_RESTART: file and MPI calls under way must not fail for it. Signals that are ignored stay ignored,
 * because nohup sets them so on purpose. */
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
