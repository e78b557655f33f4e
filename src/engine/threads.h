/* Threads for one task, which sleep while they wait. OpenMP's own threads keep their cores busy for some
 * milliseconds while they wait; on a busy machine the threads that they wait for do not get this time. Each
 * thread runs where OpenMP would bind it (OMP_PROC_BIND, OMP_PLACES).
 * SPDX-License-Identifier: MIT */
#pragma once

struct cml_thread_task {
    void *context;
    void (*body)(void *context, int number);
    void (*fewer)(void *context, int count); /* told that only `count` threads run; NULL: not told */
};

/* Runs task->body(context, number) on `count` threads side by side, with the numbers 0..count - 1; 0 is the
 * caller. Returns when all have ended. If the system refuses to start a thread, only those with the first
 * numbers run, at least the caller. Then task->fewer is told how many before the caller begins its body. */
void cml_run_threads(int count, const struct cml_thread_task *task);
