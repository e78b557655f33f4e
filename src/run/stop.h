/* Signals that ask a run to stop so that it can be resumed: SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGUSR2,
 * SIGXCPU. SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

/* Ignores SIGPIPE and SIGXFSZ, which would end the process silently when a pipe has no reader or a file may
 * not grow. The write then fails instead, with a message and an exit code. */
void cml_stop_ignore(void);

/* Ends the process without a message, as a pipe without a reader does by default: exit code 128 + SIGPIPE. */
void cml_stop_without_reader(void);

/* Asks the kernel to send SIGTERM to this process when the thread that started it ends: a run of the Python
 * package stops with Python, however Python ends. Works only if CLUSTERMCML_PARENT is the number of the
 * parent process, so not where a script stands between. */
void cml_stop_with_parent(void);

/* From this call on, a signal that asks to stop ends the process at once with CML_E_STOPPED and a line of
 * text. Ignored signals stay ignored. Call it after MPI_Init, which may set handlers of its own. */
void cml_stop_before_flight(void);

/* From this call on (after cml_stop_before_flight) the first signal that asks to stop is remembered. A second
 * one more than a second later ends the process. */
void cml_stop_watch(void);

/* True if a signal that asks to stop has come since cml_stop_watch. */
bool cml_stop_requested(void);
