/* SPDX-License-Identifier: MIT */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include "engine/threads.h"

#include <omp.h>
#include <pthread.h>
#include <sched.h>
#include <stdlib.h>

/* Size of a thread's stack, bytes. The deepest loops of a bundle were seen to use 54 kB (x86-64, gcc 12, all
 * samples). A default stack would be as large as `ulimit -s` says, which may be too little, or gigabytes. */
#define STACK_SIZE ((size_t)1 << 20)

struct thread {
    pthread_t id;
    int number;
    const struct cml_thread_task *task;
};

/* Runs the task's body on a new thread: the function with which pthread_create starts it. */
static void *begin(void *thread)
{
    const struct thread *self = thread;
    self->task->body(self->task->context, self->number);
    return NULL;
}

/* Returns the place of OpenMP (a set of cores; OpenMP 5.2, 10.1.3) for a thread: beside that of the
 * caller, or as far apart from the other threads as possible. If there are more threads than places, they
 * share the places evenly. */
static int place_of(int number, int count)
{
    const omp_proc_bind_t bind = omp_get_proc_bind();
    const int places = omp_get_num_places(), first = omp_get_place_num();
    if (bind == omp_proc_bind_master) return first;
    if (bind != omp_proc_bind_spread && count <= places) return (first + number) % places;
    return (int)((first + (long)number * places / count) % places);
}

/* Binds a thread that is to be created to the cores of a place. If memory for the numbers of the cores runs
 * out, the thread may run wherever its creator may. */
static void bind_to_place(int place, pthread_attr_t *attributes)
{
    const int count = omp_get_place_num_procs(place);
    int *ids = count > 0 ? calloc((size_t)count, sizeof *ids) : NULL;
    cpu_set_t cores;
    CPU_ZERO(&cores);
    if (!ids) return;
    omp_get_place_proc_ids(place, ids);
    for (int i = 0; i < count; i++)
        if (ids[i] < CPU_SETSIZE) CPU_SET((size_t)ids[i], &cores);
    pthread_attr_setaffinity_np(attributes, sizeof cores, &cores);
    free(ids);
}

/* Starts a thread with its own stack size, bound to cores if OpenMP binds threads. Returns 0 if it runs,
 * otherwise an error number. */
static int start(struct thread *thread, int count)
{
    pthread_attr_t attributes;
    int failed = pthread_attr_init(&attributes);
    if (failed) return failed;
    pthread_attr_setstacksize(&attributes, STACK_SIZE);
    if (omp_get_proc_bind() != omp_proc_bind_false && omp_get_num_places() > 0)
        bind_to_place(place_of(thread->number, count), &attributes);
    failed = pthread_create(&thread->id, &attributes, begin, thread);
    pthread_attr_destroy(&attributes);
    return failed;
}

void cml_run_threads(int count, const struct cml_thread_task *task)
{
    struct thread *threads = count > 1 ? calloc((size_t)count, sizeof *threads) : NULL;
    int started = 1;
    for (; threads && started < count; started++) {
        threads[started] = (struct thread){.number = started, .task = task};
        if (start(&threads[started], count)) break;
    }
    if (started < count && task->fewer) task->fewer(task->context, started);
    task->body(task->context, 0);
    for (int i = 1; threads && i < started; i++) pthread_join(threads[i].id, NULL);
    free(threads);
}
