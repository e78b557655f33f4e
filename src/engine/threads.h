/* Threads for one task, that wait asleep. OpenMP's own keep their cores for some milliseconds where they
 * wait: on a machine whose cores are busy that is time that the threads they wait for do not get. Each runs
 * where OpenMP would bind it (OMP_PROC_BIND, OMP_PLACES). SPDX-License-Identifier: MIT */
#pragma once

struct cml_thread_task {
    void *context;
    void (*body)(void *context, int number);
    void (*fewer)(void *context, int count); /* NULL: not told */
};

/* task->body(context, number) on `count` threads side by side, numbers 0..count - 1; 0 is the caller. Returns
 * when all have ended. Where the system refuses to start a thread, fewer run, those of the first numbers: the
 * caller at least. task->fewer is told how many before the caller begins its body. */
void cml_run_threads(int count, const struct cml_thread_task *task);
