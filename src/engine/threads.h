/* Threads for one task, that wait asleep. OpenMP's own keep their cores for some milliseconds where they
 * wait: on a machine whose cores are busy that is time that the threads they wait for do not get. Each runs
 * where OpenMP would bind it (OMP_PROC_BIND, OMP_PLACES). SPDX-License-Identifier: MIT */
#ifndef CML_THREADS_H
#define CML_THREADS_H

/* body(context, number) on `count` threads side by side, numbers 0..count - 1; 0 is the caller. Returns when
 * all have ended. Fewer where the system refuses to start a thread, or OMP_THREAD_LIMIT is smaller; the
 * numbers that run are the first ones. */
void cml_run_threads(int count, void (*body)(void *context, int number), void *context);

#endif
