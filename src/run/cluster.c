/* SPDX-License-Identifier: MIT */
#include "run/cluster.h"

#include "base/clock.h"
#include "run/cores.h"
#include "run/launcher.h"

#include <mpi.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { TAG_PULSE = 1, TAG_QUESTION, TAG_ANSWER };

#define HOST_SIZE 64
#define SLICE_CELLS ((size_t)1 << 18)  /* of a sum: 4 MiB */
#define SLICE_BYTES ((size_t)64 << 20) /* of a block sent to all */

/* What a rank keeps about one that it exchanges pulses with: rank 0 about all, the others about rank 0. */
struct peer {
    double heard;    /* on the attendant's clock */
    double sent;     /* the last pulse */
    uint64_t told;   /* number of the meeting that it said */
    uint64_t number; /* the pulse under way */
    MPI_Request pulse;
};

static struct {
    int rank, size, local_rank, local_size;
    int fair_cores;
    MPI_Datatype cell, summary;
    MPI_Op add_cells, add_summary;
    struct peer *peer; /* [size] on rank 0, [1] on others */
    char (*host)[HOST_SIZE];
    pthread_mutex_t lock; /* around every call of MPI once the attendant lives */
    pthread_t attendant;
    double clock; /* the attendant's: stands still while the process is stopped */
    _Atomic double patience;
    atomic_bool leaving;
    atomic_int silent;             /* rank that contact was lost with; -1: none */
    _Atomic uint64_t called, held; /* meetings */
    pthread_mutex_t desk;          /* around the clerk */
    cml_cluster_clerk *clerk;
    void *clerk_context;
} world = {.size = 1,
           .local_size = 1,
           .patience = 60,
           .silent = -1,
           .lock = PTHREAD_MUTEX_INITIALIZER,
           .desk = PTHREAD_MUTEX_INITIALIZER};

static void nap(double seconds)
{
    const struct timespec t = {(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))};
    nanosleep(&t, NULL);
}

/* ---- waiting
 * ------------------------------------------------------------------------------------------------ */

static cml_status fail_mpi(int code, struct cml_error *err)
{
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(code, text, &length);
    return cml_fail(err, CML_E_IO, "MPI failed (%s)", text);
}

static cml_status fail_silent(struct cml_error *err)
{
    const int rank = atomic_load(&world.silent);
    return cml_fail(err, CML_E_IO,
                    "contact lost: nothing heard from rank %d on %s for %g s (process, host or network down; "
                    "--resume continues from the last checkpoint)",
                    rank, world.host[rank], world.patience);
}

/* First without sleep, because most answers come at once; then with naps that leave the core to those who
 * fly. */
static cml_status wait_for(MPI_Request *request, struct cml_error *err)
{
    for (int turns = 0;; turns++) {
        int done = 0;
        pthread_mutex_lock(&world.lock);
        const int code = MPI_Test(request, &done, MPI_STATUS_IGNORE);
        pthread_mutex_unlock(&world.lock);
        if (code != MPI_SUCCESS) return fail_mpi(code, err);
        if (done) return CML_OK;
        if (atomic_load(&world.silent) >= 0) return fail_silent(err);
        if (turns < 1000)
            sched_yield();
        else
            nap(turns < 20000 ? 5e-5 : 1e-3);
    }
}

/* Starts a nonblocking call under the lock and waits for its end. */
#define COMPLETE(start, err) (pthread_mutex_lock(&world.lock), finish(start, &request, err))

static cml_status finish(int code, MPI_Request *request, struct cml_error *err)
{
    pthread_mutex_unlock(&world.lock);
    return code == MPI_SUCCESS ? wait_for(request, err) : fail_mpi(code, err);
}

/* ---- the attendant
 * ------------------------------------------------------------------------------------------ */

static void raise_called(uint64_t number)
{
    uint64_t known = atomic_load(&world.called);
    while (known < number && !atomic_compare_exchange_weak(&world.called, &known, number)) continue;
}

/* The next message with this tag, if there is one. */
static bool receive(int tag, void *data, int size, int *from)
{
    int found = 0;
    MPI_Status status;
    pthread_mutex_lock(&world.lock);
    MPI_Iprobe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &found, &status);
    if (found) MPI_Recv(data, size, MPI_BYTE, status.MPI_SOURCE, tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    pthread_mutex_unlock(&world.lock);
    if (found) *from = status.MPI_SOURCE;
    return found != 0;
}

static void receive_pulses(void)
{
    uint64_t number = 0;
    int from = 0;
    while (receive(TAG_PULSE, &number, sizeof number, &from)) {
        world.peer[from].heard = world.clock;
        raise_called(number);
    }
}

static void answer_questions(void)
{
    struct cml_question question;
    struct cml_answer answer;
    int from = 0;
    while (receive(TAG_QUESTION, &question, sizeof question, &from)) {
        MPI_Request request;
        struct cml_error ignored; /* silence: whoever waits will see it too */
        answer = (struct cml_answer){0};
        world.peer[from].heard = world.clock;
        pthread_mutex_lock(&world.desk);
        if (world.clerk) world.clerk(world.clerk_context, from, &question, &answer);
        pthread_mutex_unlock(&world.desk);
        if (COMPLETE(MPI_Isend(&answer, sizeof answer, MPI_BYTE, from, TAG_ANSWER, MPI_COMM_WORLD, &request),
                     &ignored) != CML_OK)
            return;
    }
}

/* Says that this rank lives, and which meeting was called: now and then, and when there is news. */
static void send_pulse(struct peer *peer, int to)
{
    const uint64_t called = atomic_load(&world.called);
    if (called == peer->told && world.clock - peer->sent < world.patience / 4) return;
    int done = 0;
    MPI_Test(&peer->pulse, &done, MPI_STATUS_IGNORE);
    if (!done) return;
    peer->number = called;
    MPI_Isend(&peer->number, sizeof peer->number, MPI_BYTE, to, TAG_PULSE, MPI_COMM_WORLD, &peer->pulse);
    peer->told = called;
    peer->sent = world.clock;
}

static int first_peer(void)
{
    return world.rank == 0 ? 1 : 0;
}

static int end_of_peers(void)
{
    return world.rank == 0 ? world.size : 1;
}

static void send_pulses(void)
{
    pthread_mutex_lock(&world.lock);
    for (int i = first_peer(); i < end_of_peers(); i++) send_pulse(&world.peer[i], i);
    pthread_mutex_unlock(&world.lock);
}

static void check_silence(void)
{
    for (int i = first_peer(); i < end_of_peers(); i++)
        if (world.clock - world.peer[i].heard > world.patience) atomic_store(&world.silent, i);
}

static void *attend(void *unused)
{
    double last = cml_now();
    while (!atomic_load(&world.leaving)) {
        const double time = cml_now();
        world.clock +=
            time - last < 0.1 ? time - last : 0.1; /* a stopped process does not count its own sleep */
        last = time;
        receive_pulses();
        if (world.rank == 0) answer_questions();
        send_pulses();
        check_silence();
        nap(world.rank == 0 ? 1e-3 : 5e-3);
    }
    return unused;
}

/* ---- beginning and end
 * -------------------------------------------------------------------------------------- */

static void add_cells(void *in, void *inout, int *count, MPI_Datatype *type)
{
    (void)type;
    for (size_t i = 0; i < (size_t)*count; i++) { /* copies, for MPI promises no alignment */
        cml_u128 from, to;
        memcpy(&from, (const char *)in + i * sizeof from, sizeof from);
        memcpy(&to, (char *)inout + i * sizeof to, sizeof to);
        to += from;
        memcpy((char *)inout + i * sizeof to, &to, sizeof to);
    }
}

static void add_summaries(void *in, void *inout, int *count, MPI_Datatype *type)
{
    (void)type;
    for (size_t i = 0; i < (size_t)*count; i++) {
        struct cml_summary from, to;
        memcpy(&from, (const char *)in + i * sizeof from, sizeof from);
        memcpy(&to, (char *)inout + i * sizeof to, sizeof to);
        cml_summary_merge(&to, &from);
        memcpy((char *)inout + i * sizeof to, &to, sizeof to);
    }
}

static void create_types(void)
{
    MPI_Type_contiguous(sizeof(cml_u128), MPI_BYTE, &world.cell);
    MPI_Type_contiguous(sizeof(struct cml_summary), MPI_BYTE, &world.summary);
    MPI_Type_commit(&world.cell);
    MPI_Type_commit(&world.summary);
    MPI_Op_create(add_cells, 1, &world.add_cells);
    MPI_Op_create(add_summaries, 1, &world.add_summary);
}

static void look_at_cores(MPI_Comm machine)
{
    struct cml_cores mine, all;
    cml_cores_mine(&mine);
    MPI_Allreduce(&mine, &all, sizeof mine, MPI_BYTE, MPI_BOR, machine);
    const int share = cml_cores_count(&all) / world.local_size, most = cml_cores_count(&mine);
    world.fair_cores = share < 1 ? 1 : share < most ? share : most;
}

static void look_around(void)
{
    MPI_Comm machine;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, world.rank, MPI_INFO_NULL, &machine);
    MPI_Comm_rank(machine, &world.local_rank);
    MPI_Comm_size(machine, &world.local_size);
    look_at_cores(machine);
    MPI_Comm_free(&machine);
    char name[MPI_MAX_PROCESSOR_NAME] = "", host[HOST_SIZE] = "";
    int length = 0;
    MPI_Get_processor_name(name, &length);
    memcpy(host, name, sizeof host - 1);
    MPI_Allgather(host, sizeof host, MPI_BYTE, world.host, sizeof host, MPI_BYTE, MPI_COMM_WORLD);
}

static cml_status join_world(struct cml_error *err)
{
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    world.peer = calloc((size_t)end_of_peers(), sizeof *world.peer);
    world.host = calloc((size_t)world.size, sizeof *world.host);
    if (!world.peer || !world.host) return cml_fail_memory(err, world.size * 128.0, "the ranks");
    for (int i = 0; i < end_of_peers(); i++) world.peer[i].pulse = MPI_REQUEST_NULL;
    create_types();
    look_around();
    if (pthread_create(&world.attendant, NULL, attend, NULL) != 0)
        return cml_fail(err, CML_E_DEVICE, "the thread that answers other ranks cannot start");
    return CML_OK;
}

cml_status cml_cluster_begin(int *argc, char ***argv, struct cml_error *err)
{
    if (!cml_launcher_found()) return CML_OK;
    int level = 0;
    if (MPI_Init_thread(argc, argv, MPI_THREAD_SERIALIZED, &level) != MPI_SUCCESS)
        return cml_fail(err, CML_E_DEVICE, "MPI cannot start");
    MPI_Comm_rank(MPI_COMM_WORLD, &world.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &world.size);
    cml_status status = cml_launcher_check(world.size, err);
    if (status == CML_OK && level < MPI_THREAD_SERIALIZED)
        status = cml_fail(err, CML_E_DEVICE, "this MPI library does not support MPI_THREAD_SERIALIZED");
    return status == CML_OK && world.size > 1 ? join_world(err) : status;
}

/* Pulses that crossed the end. */
static void drain(void)
{
    uint64_t number = 0;
    int from = 0;
    while (receive(TAG_PULSE, &number, sizeof number, &from)) continue;
    for (int i = first_peer(); i < end_of_peers(); i++) MPI_Wait(&world.peer[i].pulse, MPI_STATUS_IGNORE);
}

/* mpiexec that is told to end the ranks of a lost host, before it found out itself, waits for that host's
 * answer until TCP gives up, a quarter of an hour; so does its daemon there, when it has something to say. */
void cml_cluster_leave_it_to_the_launcher(void)
{
    for (double waited = 0; waited < 2 * world.patience; waited += 0.1) nap(0.1);
}

void cml_cluster_end(cml_status status)
{
    int begun = 0;
    MPI_Initialized(&begun);
    if (!begun) return;
    if (cml_cluster_broken()) MPI_Abort(MPI_COMM_WORLD, (int)status);
    if (world.size > 1) {
        atomic_store(&world.leaving, true);
        pthread_join(world.attendant, NULL);
        drain();
        free(world.peer);
        free(world.host);
    }
    MPI_Finalize();
}

int cml_cluster_rank(void)
{
    return world.rank;
}

int cml_cluster_size(void)
{
    return world.size;
}

int cml_cluster_local_rank(void)
{
    return world.local_rank;
}

int cml_cluster_local_size(void)
{
    return world.local_size;
}

int cml_cluster_fair_cores(void)
{
    return world.fair_cores;
}

void cml_cluster_set_patience(double seconds)
{
    world.patience = seconds;
}

bool cml_cluster_broken(void)
{
    return atomic_load(&world.silent) >= 0;
}

/* ---- together
 * ----------------------------------------------------------------------------------------------- */

cml_status cml_cluster_agree(cml_status mine, struct cml_error *err)
{
    if (world.size == 1) return mine;
    if (cml_cluster_broken()) return mine != CML_OK ? mine : fail_silent(err);
    struct {
        int status, rank;
    } worst = {(int)mine, world.rank};
    MPI_Request request;
    CML_TRY(COMPLETE(MPI_Iallreduce(MPI_IN_PLACE, &worst, 1, MPI_2INT, MPI_MAXLOC, MPI_COMM_WORLD, &request),
                     err));
    if (worst.status == CML_OK) return CML_OK;
    CML_TRY(COMPLETE(MPI_Ibcast(err, sizeof *err, MPI_BYTE, worst.rank, MPI_COMM_WORLD, &request), err));
    return (cml_status)worst.status;
}

cml_status cml_cluster_share(void *data, size_t size, struct cml_error *err)
{
    MPI_Request request;
    char *bytes = data;
    for (size_t done = 0; world.size > 1 && done < size; done += SLICE_BYTES) {
        const size_t count = size - done < SLICE_BYTES ? size - done : SLICE_BYTES;
        CML_TRY(COMPLETE(MPI_Ibcast(bytes + done, (int)count, MPI_BYTE, 0, MPI_COMM_WORLD, &request), err));
    }
    return CML_OK;
}

cml_status cml_cluster_share_block(char **block, size_t *size, struct cml_error *err)
{
    cml_status status = CML_OK;
    CML_TRY(cml_cluster_share(size, sizeof *size, err));
    if (world.rank != 0) {
        *block = malloc(*size);
        if (!*block) status = cml_fail_memory(err, (double)*size, "what rank 0 sends");
    }
    CML_TRY(cml_cluster_agree(status, err));
    return cml_cluster_share(*block, *size, err);
}

cml_status cml_cluster_gather(const void *mine, size_t size, void *all, struct cml_error *err)
{
    if (world.size == 1) {
        memcpy(all, mine, size);
        return CML_OK;
    }
    MPI_Request request;
    return COMPLETE(
        MPI_Igather(mine, (int)size, MPI_BYTE, all, (int)size, MPI_BYTE, 0, MPI_COMM_WORLD, &request), err);
}

/* Into rank 0's own elements. */
static cml_status sum_elements(void *elements, int count, MPI_Datatype type, MPI_Op op, struct cml_error *err)
{
    MPI_Request request;
    const void *from = world.rank == 0 ? MPI_IN_PLACE : elements;
    return COMPLETE(MPI_Ireduce(from, elements, count, type, op, 0, MPI_COMM_WORLD, &request), err);
}

cml_status cml_cluster_sum(struct cml_result *result, struct cml_error *err)
{
    if (world.size == 1) return CML_OK;
    size_t cells = 0;
    cml_u128 *cell = cml_result_cells(result, &cells);
    for (size_t done = 0; done < cells; done += SLICE_CELLS) {
        const size_t count = cells - done < SLICE_CELLS ? cells - done : SLICE_CELLS;
        CML_TRY(sum_elements(cell + done, (int)count, world.cell, world.add_cells, err));
    }
    CML_TRY(sum_elements(&result->summary, 1, world.summary, world.add_summary, err));
    if (world.rank != 0) {
        memset(cell, 0, cells * sizeof *cell);
        memset(&result->summary, 0, sizeof result->summary);
    }
    return CML_OK;
}

/* ---- meetings and questions
 * --------------------------------------------------------------------------------- */

void cml_cluster_call(void)
{
    raise_called(atomic_load(&world.held) + 1);
}

bool cml_cluster_called(void)
{
    return atomic_load(&world.called) > atomic_load(&world.held);
}

cml_status cml_cluster_meet(struct cml_error *err)
{
    MPI_Request request;
    cml_cluster_call();
    if (world.size > 1) CML_TRY(COMPLETE(MPI_Ibarrier(MPI_COMM_WORLD, &request), err));
    atomic_fetch_add(&world.held, 1);
    return CML_OK;
}

void cml_cluster_serve(cml_cluster_clerk *clerk, void *context)
{
    pthread_mutex_lock(&world.desk);
    world.clerk = clerk;
    world.clerk_context = context;
    pthread_mutex_unlock(&world.desk);
}

cml_status cml_cluster_ask(const struct cml_question *question, struct cml_answer *answer,
                           struct cml_error *err)
{
    MPI_Request request, reply;
    pthread_mutex_lock(&world.lock);
    int code = MPI_Irecv(answer, sizeof *answer, MPI_BYTE, 0, TAG_ANSWER, MPI_COMM_WORLD, &reply);
    if (code == MPI_SUCCESS)
        code = MPI_Isend(question, sizeof *question, MPI_BYTE, 0, TAG_QUESTION, MPI_COMM_WORLD, &request);
    CML_TRY(finish(code, &request, err));
    return wait_for(&reply, err);
}
