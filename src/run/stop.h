/* Signals that ask the run to stop so that it can be resumed: SIGTERM, SIGINT, SIGUSR1, SIGUSR2, SIGXCPU.
 * SPDX-License-Identifier: MIT */
#ifndef CML_STOP_H
#define CML_STOP_H

#include <stdbool.h>

/* A pipe that nobody reads and a file that may not grow become errors of the write, with a message and an
 * exit code, where they would else end the process. */
void cml_stop_ignore(void);

/* From now on a pipe that nobody reads ends the process, without a word. */
void cml_stop_without_reader(void);

/* From here on the first of the signals is remembered, the second ends the process at once. Signals that were
 * ignored stay ignored. Call it after MPI_Init, which may set handlers of its own. */
void cml_stop_watch(void);

/* Whether one of them has come since. */
bool cml_stop_requested(void);

#endif
