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

enum { TAG_HEARTBEAT = 1, TAG_REQUEST, TAG_REPLY };

#define HOST_SIZE 64
#define SLICE_CELLS ((size_t)1 << 18)  /* of a sum: 4 MiB, which keeps MPI's own buffers small */
#define SLICE_BYTES ((size_t)64 << 20) /* of a block sent to all: counts of MPI are ints */

/* What a rank keeps about its peers: rank 0 about all others, the others about rank 0. */
struct peer {
    double heard;          /* last, on the service clock */
    double sent;           /* the last heartbeat, on the same clock */
    uint64_t syncs_told;   /* syncs_requested as it said */
    uint64_t message;      /* of the heartbeat under way: MPI reads it until that is complete */
    MPI_Request heartbeat; /* MPI_REQUEST_NULL: none is under way */
};

/* A process is one rank, so this is its only state. What the service thread and others both use is atomic or
 * under a lock. */
static struct {
    int rank, size, local_rank, local_size, fair_cores;
    MPI_Datatype cell, summary;
    MPI_Op add_cells, add_summary;
    struct peer *peer;       /* [size] on rank 0, [1] on others; the service thread's alone */
    char (*host)[HOST_SIZE]; /* [size] */
    pthread_mutex_t lock;    /* around every call of MPI once the service thread runs */
    pthread_t service;
    double clock;           /* s, the service thread's: stands still while the process is stopped */
    _Atomic double timeout; /* s */
    atomic_bool leaving;
    atomic_int lost_rank;                         /* that contact was lost with; -1: none */
    _Atomic uint64_t syncs_requested, syncs_done; /* numbers of the last ones */
    pthread_mutex_t handler_lock; /* held while the handler runs, so that it can be taken away safely */
    cml_cluster_handler *handler;
    void *handler_context;
} world = {.size = 1,
           .local_size = 1,
           .timeout = 60,
           .lost_rank = -1,
           .lock = PTHREAD_MUTEX_INITIALIZER,
           .handler_lock = PTHREAD_MUTEX_INITIALIZER};

static void sleep_for(double seconds)
{
    const struct timespec t = {(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))};
    nanosleep(&t, NULL);
}

/* ---- waiting ---- */

static cml_status fail_mpi(int code, struct cml_error *err)
{
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(code, text, &length);
    return cml_fail(err, CML_E_IO, "MPI failed (%s)", text);
}

static cml_status fail_contact_lost(struct cml_error *err)
{
    const int rank = atomic_load(&world.lost_rank);
    return cml_fail(err, CML_E_IO,
                    "contact lost: nothing heard from rank %d on %s for %g s (process, host or network down; "
                    "--resume continues from the last checkpoint)",
                    rank, world.host[rank], world.timeout);
}

/* Waits for a nonblocking call to complete, but not for a lost rank. First without sleep, because most
 * replies come at once; then with short sleeps, which leave the core to those who compute. */
static cml_status wait_for(MPI_Request *call, struct cml_error *err)
{
    for (int tries = 0;; tries++) {
        int done = 0;
        pthread_mutex_lock(&world.lock);
        const int code = MPI_Test(call, &done, MPI_STATUS_IGNORE);
        pthread_mutex_unlock(&world.lock);
        if (code != MPI_SUCCESS) return fail_mpi(code, err);
        if (done) return CML_OK;
        if (atomic_load(&world.lost_rank) >= 0) return fail_contact_lost(err);
        if (tries < 1000)
            sched_yield();
        else
            sleep_for(tries < 20000 ? 5e-5 : 1e-3);
    }
}

/* Starts a nonblocking call of MPI, which leaves its MPI_Request in `call`, and waits for its end. A macro,
 * because the call itself must run under the lock. */
#define COMPLETE(start, err) (pthread_mutex_lock(&world.lock), finish(start, &call, err))

static cml_status finish(int code, MPI_Request *call, struct cml_error *err)
{
    pthread_mutex_unlock(&world.lock);
    return code == MPI_SUCCESS ? wait_for(call, err) : fail_mpi(code, err);
}

/* ---- the service thread ---- */

/* Synchronisations are numbered, so that a request that arrives late, or twice, asks for nothing new. */
static void raise_requested(uint64_t number)
{
    uint64_t known = atomic_load(&world.syncs_requested);
    while (known < number && !atomic_compare_exchange_weak(&world.syncs_requested, &known, number)) continue;
}

/* The next message with this tag, if there is one. A blocking receive, because the message is there. */
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

static void receive_heartbeats(void)
{
    uint64_t number = 0;
    int from = 0;
    while (receive(TAG_HEARTBEAT, &number, sizeof number, &from)) {
        world.peer[from].heard = world.clock;
        raise_requested(number);
    }
}

/* On rank 0. The reply is waited for, under the same watch for lost ranks as every other call. */
static void answer_requests(void)
{
    struct cml_work_request request;
    struct cml_work_reply reply;
    int from = 0;
    while (receive(TAG_REQUEST, &request, sizeof request, &from)) {
        MPI_Request call;
        struct cml_error ignored; /* whoever else waits will see that contact is lost */
        reply = (struct cml_work_reply){0};
        world.peer[from].heard = world.clock;
        pthread_mutex_lock(&world.handler_lock);
        if (world.handler) world.handler(world.handler_context, from, &request, &reply);
        pthread_mutex_unlock(&world.handler_lock);
        if (COMPLETE(MPI_Isend(&reply, sizeof reply, MPI_BYTE, from, TAG_REPLY, MPI_COMM_WORLD, &call),
                     &ignored) != CML_OK)
            return;
    }
}

/* Says that this rank lives, and which synchronisation was requested: four times per timeout, and at once
 * when there is news. Rank 0 passes requests on, because the others hear it alone. */
static void send_heartbeat(struct peer *peer, int to)
{
    const uint64_t requested = atomic_load(&world.syncs_requested);
    if (requested == peer->syncs_told && world.clock - peer->sent < world.timeout / 4) return;
    int done = 0;
    MPI_Test(&peer->heartbeat, &done, MPI_STATUS_IGNORE);
    if (!done) return;
    peer->message = requested;
    MPI_Isend(&peer->message, sizeof peer->message, MPI_BYTE, to, TAG_HEARTBEAT, MPI_COMM_WORLD,
              &peer->heartbeat);
    peer->syncs_told = requested;
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

static void send_heartbeats(void)
{
    pthread_mutex_lock(&world.lock);
    for (int i = first_peer(); i < end_of_peers(); i++) send_heartbeat(&world.peer[i], i);
    pthread_mutex_unlock(&world.lock);
}

static void check_heartbeats(void)
{
    for (int i = first_peer(); i < end_of_peers(); i++)
        if (world.clock - world.peer[i].heard > world.timeout) atomic_store(&world.lost_rank, i);
}

/* The service thread. A process that was stopped (SIGSTOP, a suspended machine) must not find on waking that
 * all others have been silent, so the clock counts at most 0.1 s a round. */
static void *serve(void *unused)
{
    double last = cml_now();
    while (!atomic_load(&world.leaving)) {
        const double time = cml_now();
        world.clock += time - last < 0.1 ? time - last : 0.1;
        last = time;
        receive_heartbeats();
        if (world.rank == 0) answer_requests();
        send_heartbeats();
        check_heartbeats();
        sleep_for(world.rank == 0 ? 1e-3 : 5e-3);
    }
    return unused;
}

/* ---- beginning and end ---- */

/* MPI knows no integers of 128 bits: sums of cells and of summaries are operations of our own, on types that
 * are bytes to MPI. Both commute, as MPI_Op_create is told. */

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

/* The cores that any rank of the machine may run on, shared evenly, but not more than this one may run on. */
static void share_cores(MPI_Comm machine)
{
    struct cml_cores mine, all;
    cml_cores_mine(&mine);
    MPI_Allreduce(&mine, &all, sizeof mine, MPI_BYTE, MPI_BOR, machine);
    const int share = cml_cores_count(&all) / world.local_size, most = cml_cores_count(&mine);
    world.fair_cores = share < 1 ? 1 : share < most ? share : most;
}

/* Which ranks share this machine, and the names of all hosts for messages. Before the service thread runs, so
 * these calls may block. */
static void find_machine(void)
{
    MPI_Comm machine;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, world.rank, MPI_INFO_NULL, &machine);
    MPI_Comm_rank(machine, &world.local_rank);
    MPI_Comm_size(machine, &world.local_size);
    share_cores(machine);
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
    for (int i = 0; i < end_of_peers(); i++) world.peer[i].heartbeat = MPI_REQUEST_NULL;
    create_types();
    find_machine();
    if (pthread_create(&world.service, NULL, serve, NULL) != 0)
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

/* Heartbeats that were under way when the others left: MPI_Finalize wants every message received. */
static void drain(void)
{
    uint64_t number = 0;
    int from = 0;
    while (receive(TAG_HEARTBEAT, &number, sizeof number, &from)) continue;
    for (int i = first_peer(); i < end_of_peers(); i++) MPI_Wait(&world.peer[i].heartbeat, MPI_STATUS_IGNORE);
}

/* Why not abort at once: mpiexec that is told to end the ranks of a lost host, before it found out itself,
 * waits for that host's answer until TCP gives up, a quarter of an hour; so does its daemon there, when it
 * has something to say. */
void cml_cluster_await_launcher(void)
{
    for (double waited = 0; waited < 2 * world.timeout; waited += 0.1) sleep_for(0.1);
}

void cml_cluster_end(cml_status status)
{
    int begun = 0;
    MPI_Initialized(&begun);
    if (!begun) return;
    if (cml_cluster_contact_lost()) MPI_Abort(MPI_COMM_WORLD, (int)status);
    if (world.size > 1) {
        atomic_store(&world.leaving, true);
        pthread_join(world.service, NULL);
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

void cml_cluster_set_timeout(double seconds)
{
    world.timeout = seconds;
}

bool cml_cluster_contact_lost(void)
{
    return atomic_load(&world.lost_rank) >= 0;
}

/* ---- together ---- */

cml_status cml_cluster_agree(cml_status mine, struct cml_error *err)
{
    if (world.size == 1) return mine;
    if (cml_cluster_contact_lost()) return mine != CML_OK ? mine : fail_contact_lost(err);
    struct {
        int status, rank;
    } worst = {(int)mine, world.rank};
    MPI_Request call;
    CML_TRY(
        COMPLETE(MPI_Iallreduce(MPI_IN_PLACE, &worst, 1, MPI_2INT, MPI_MAXLOC, MPI_COMM_WORLD, &call), err));
    if (worst.status == CML_OK) return CML_OK;
    CML_TRY(COMPLETE(MPI_Ibcast(err, sizeof *err, MPI_BYTE, worst.rank, MPI_COMM_WORLD, &call), err));
    return (cml_status)worst.status;
}

cml_status cml_cluster_share(void *data, size_t size, struct cml_error *err)
{
    MPI_Request call;
    char *bytes = data;
    for (size_t done = 0; world.size > 1 && done < size; done += SLICE_BYTES) {
        const size_t count = size - done < SLICE_BYTES ? size - done : SLICE_BYTES;
        CML_TRY(COMPLETE(MPI_Ibcast(bytes + done, (int)count, MPI_BYTE, 0, MPI_COMM_WORLD, &call), err));
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
    MPI_Request call;
    return COMPLETE(
        MPI_Igather(mine, (int)size, MPI_BYTE, all, (int)size, MPI_BYTE, 0, MPI_COMM_WORLD, &call), err);
}

/* Into rank 0's own elements: MPI wants it to say so, and the others to give theirs. */
static cml_status sum_elements(void *elements, int count, MPI_Datatype type, MPI_Op op, struct cml_error *err)
{
    MPI_Request call;
    const void *from = world.rank == 0 ? MPI_IN_PLACE : elements;
    return COMPLETE(MPI_Ireduce(from, elements, count, type, op, 0, MPI_COMM_WORLD, &call), err);
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

/* ---- synchronisations and requests ---- */

void cml_cluster_request_sync(void)
{
    raise_requested(atomic_load(&world.syncs_done) + 1);
}

bool cml_cluster_sync_requested(void)
{
    return atomic_load(&world.syncs_requested) > atomic_load(&world.syncs_done);
}

cml_status cml_cluster_synchronise(struct cml_error *err)
{
    MPI_Request call;
    cml_cluster_request_sync();
    if (world.size > 1) CML_TRY(COMPLETE(MPI_Ibarrier(MPI_COMM_WORLD, &call), err));
    atomic_fetch_add(&world.syncs_done, 1);
    return CML_OK;
}

void cml_cluster_set_handler(cml_cluster_handler *handler, void *context)
{
    pthread_mutex_lock(&world.handler_lock);
    world.handler = handler;
    world.handler_context = context;
    pthread_mutex_unlock(&world.handler_lock);
}

/* The receive is posted before the request is sent, so that the reply finds its place. */
cml_status cml_cluster_request(const struct cml_work_request *request, struct cml_work_reply *reply,
                               struct cml_error *err)
{
    MPI_Request sent, received;
    pthread_mutex_lock(&world.lock);
    int code = MPI_Irecv(reply, sizeof *reply, MPI_BYTE, 0, TAG_REPLY, MPI_COMM_WORLD, &received);
    if (code == MPI_SUCCESS)
        code = MPI_Isend(request, sizeof *request, MPI_BYTE, 0, TAG_REQUEST, MPI_COMM_WORLD, &sent);
    CML_TRY(finish(code, &sent, err));
    return wait_for(&received, err);
}
