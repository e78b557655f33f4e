/* Signals that ask the run to stop so that it can be resumed: SIGTERM, SIGINT, SIGUSR1, SIGUSR2, SIGXCPU.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>

/* A pipe that nobody reads and a file that may not grow become errors of the write, with a message and an
 * exit code, where they would else end the process. */
void cml_stop_ignore(void);

/* Ends the process as a pipe that nobody reads does by itself, without a word: 128 + SIGPIPE. */
void cml_stop_without_reader(void);

/* Has the kernel send SIGTERM to this process when the thread that started it ends: a run of the Python
 * package stops with Python, however Python ends. CLUSTERMCML_PARENT must be the number of the parent
 * process; else nothing happens, as where a script stands between. */
void cml_stop_with_parent(void);

/* From here on one of the signals ends the process at once with CML_E_STOPPED and a line. Signals that were
 * ignored stay ignored. Call it after MPI_Init, which may set handlers of its own. */
void cml_stop_before_flight(void);

/* From here on, after cml_stop_before_flight, the first of them is remembered; one that comes more than a
 * second after it ends the process. */
void cml_stop_watch(void);

/* Whether one of them has come since. */
bool cml_stop_requested(void);
