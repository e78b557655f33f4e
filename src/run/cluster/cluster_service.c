/* The service thread of a rank, and all waiting between ranks: heartbeats, requests for work,
 * synchronisations. SPDX-License-Identifier: MIT */
#include "run/cluster/cluster_parts.h"

#include "base/clock.h"

#include <sched.h>
#include <stdlib.h>
#include <time.h>

enum { TAG_HEARTBEAT = 1, TAG_REQUEST, TAG_REPLY };

/* State of one peer. The peers of rank 0 are all other ranks; the only peer of another rank is rank 0. */
struct peer {
    double heard;          /* time of the last message from the peer, on the service clock */
    double sent;           /* time of the last heartbeat to the peer, on the service clock */
    uint64_t syncs_told;   /* value of syncs_requested in the last heartbeat to the peer */
    uint64_t message;      /* content of the heartbeat under way; MPI reads it until the send is complete */
    MPI_Request heartbeat; /* send of the heartbeat; MPI_REQUEST_NULL: none is under way */
};

static struct {
    struct peer *peer; /* [size] on rank 0, [1] elsewhere; only the service thread uses it */
    pthread_t thread;
    /* s; only the service thread advances it, and it stands still while the process is stopped */
    double clock;
    atomic_bool leaving;
    /* the last request (see raise_requested), and the number of synchronisations that have taken place */
    _Atomic uint64_t syncs_requested, syncs_done;
    /* held while the handler runs, so that the handler can be replaced safely */
    pthread_mutex_t handler_lock;
    cml_cluster_handler *handler;
    void *handler_context;
} service = {.handler_lock = PTHREAD_MUTEX_INITIALIZER};

void cml_cluster_sleep(double seconds)
{
    const struct timespec t = {(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))};
    nanosleep(&t, NULL);
}

/* ---- waiting ---- */

/* Makes an error message from an error code of MPI. */
static cml_status fail_mpi(int code, struct cml_error *err)
{
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(code, text, &length);
    return cml_fail(err, CML_E_IO, "MPI failed (%s)", text);
}

cml_status cml_cluster_fail_contact_lost(struct cml_error *err)
{
    const int rank = atomic_load(&cml_ranks.lost_rank);
    return cml_fail(err, CML_E_IO,
                    "contact lost: nothing heard from rank %d on %s for %g s (process, host or network down; "
                    "--resume continues from the last checkpoint)",
                    rank, cml_ranks.host[rank], cml_ranks.timeout);
}

/* Waits until a nonblocking call is complete, but not for a lost rank. At first without sleeping, because
 * most replies come at once; then with short sleeps, which leave the core to threads that compute. */
static cml_status wait_for(MPI_Request *call, struct cml_error *err)
{
    for (int tries = 0;; tries++) {
        int done = 0;
        pthread_mutex_lock(&cml_ranks.lock);
        const int code = MPI_Test(call, &done, MPI_STATUS_IGNORE);
        pthread_mutex_unlock(&cml_ranks.lock);
        if (code != MPI_SUCCESS) return fail_mpi(code, err);
        if (done) return CML_OK;
        if (atomic_load(&cml_ranks.lost_rank) >= 0) return cml_cluster_fail_contact_lost(err);
        if (tries < 1000)
            sched_yield();
        else
            cml_cluster_sleep(tries < 20000 ? 5e-5 : 1e-3);
    }
}

cml_status cml_cluster_complete(int code, MPI_Request *call, struct cml_error *err)
{
    pthread_mutex_unlock(&cml_ranks.lock);
    return code == MPI_SUCCESS ? wait_for(call, err) : fail_mpi(code, err);
}

/* ---- the service thread ---- */

/* Records a request for synchronisation. `number` is twice the number of the synchronisation, plus one if the
 * run is to stop there. Only the largest request is kept, so a request that arrives late or twice has no
 * effect. */
static void raise_requested(uint64_t number)
{
    uint64_t known = atomic_load(&service.syncs_requested);
    while (known < number && !atomic_compare_exchange_weak(&service.syncs_requested, &known, number))
        continue;
}

/* Receives the next message with this tag; false if there is none. The receive may block, because the message
 * is known to be there. */
static bool receive(int tag, void *data, int size, int *from)
{
    int found = 0;
    MPI_Status status;
    pthread_mutex_lock(&cml_ranks.lock);
    MPI_Iprobe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &found, &status);
    if (found) MPI_Recv(data, size, MPI_BYTE, status.MPI_SOURCE, tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    pthread_mutex_unlock(&cml_ranks.lock);
    if (found) *from = status.MPI_SOURCE;
    return found != 0;
}

/* Receives all heartbeats that have come. Each carries the last request for synchronisation that its sender
 * knows. */
static void receive_heartbeats(void)
{
    uint64_t number = 0;
    int from = 0;
    while (receive(TAG_HEARTBEAT, &number, sizeof number, &from)) {
        service.peer[from].heard = service.clock;
        raise_requested(number);
    }
}

/* Answers the requests of work that other ranks send to rank 0. Each reply is waited for, with the same
 * watch for lost ranks as every other call. */
static void answer_requests(void)
{
    struct cml_work_request request;
    struct cml_work_reply reply;
    int from = 0;
    while (receive(TAG_REQUEST, &request, sizeof request, &from)) {
        MPI_Request call;
        struct cml_error ignored; /* ignored: every thread that waits sees that contact is lost */
        reply = (struct cml_work_reply){0};
        service.peer[from].heard = service.clock;
        pthread_mutex_lock(&service.handler_lock);
        if (service.handler) service.handler(service.handler_context, from, &request, &reply);
        pthread_mutex_unlock(&service.handler_lock);
        if (CML_COMPLETE(MPI_Isend(&reply, sizeof reply, MPI_BYTE, from, TAG_REPLY, MPI_COMM_WORLD, &call),
                         &call, &ignored) != CML_OK)
            return;
    }
}

/* Tells a peer that this rank lives, and the last request for synchronisation: four times per timeout, and at
 * once when the request is new. Rank 0 passes requests on, because other ranks hear only rank 0. */
static void send_heartbeat(struct peer *peer, int to)
{
    const uint64_t requested = atomic_load(&service.syncs_requested);
    if (requested == peer->syncs_told && service.clock - peer->sent < cml_ranks.timeout / 4) return;
    int done = 0;
    MPI_Test(&peer->heartbeat, &done, MPI_STATUS_IGNORE);
    if (!done) return;
    peer->message = requested;
    MPI_Isend(&peer->message, sizeof peer->message, MPI_BYTE, to, TAG_HEARTBEAT, MPI_COMM_WORLD,
              &peer->heartbeat);
    peer->syncs_told = requested;
    peer->sent = service.clock;
}

/* Ranks exchange heartbeats with rank 0 only: the number of messages grows with the number of ranks, not with
 * its square. */
static int first_peer(void)
{
    return cml_ranks.rank == 0 ? 1 : 0;
}

/* Returns the end of the list of ranks that this rank watches: rank 0 watches all, the others only rank 0. */
static int end_of_peers(void)
{
    return cml_ranks.rank == 0 ? cml_ranks.size : 1;
}

/* Sends heartbeats to all peers under one lock: starting a message does not wait. */
static void send_heartbeats(void)
{
    pthread_mutex_lock(&cml_ranks.lock);
    for (int i = first_peer(); i < end_of_peers(); i++) send_heartbeat(&service.peer[i], i);
    pthread_mutex_unlock(&cml_ranks.lock);
}

/* Marks a rank as lost that has been silent for longer than the timeout (requests count as signs of life,
 * too). All waits fail once lost_rank is set. */
static void check_heartbeats(void)
{
    for (int i = first_peer(); i < end_of_peers(); i++)
        if (service.clock - service.peer[i].heard > cml_ranks.timeout) atomic_store(&cml_ranks.lost_rank, i);
}

/* Runs the service thread of a rank, which answers requests and exchanges signs of life. Its clock advances
 * by at most 0.1 s a round: a process that was stopped for a while (a suspended machine) must not find all
 * others silent on waking. */
static void *serve(void *unused)
{
    double last = cml_now();
    while (!atomic_load(&service.leaving)) {
        const double time = cml_now();
        service.clock += time - last < 0.1 ? time - last : 0.1;
        last = time;
        receive_heartbeats();
        if (cml_ranks.rank == 0) answer_requests();
        send_heartbeats();
        check_heartbeats();
        cml_cluster_sleep(cml_ranks.rank == 0 ? 1e-3 : 5e-3);
    }
    return unused;
}

/* Starts the service thread of this rank. The list of peers is made before, since only the thread uses it
 * afterwards. */
cml_status cml_service_start(struct cml_error *err)
{
    const size_t peers = (size_t)end_of_peers();
    service.peer = calloc(peers, sizeof *service.peer);
    if (!service.peer) return cml_fail_memory(err, (double)(peers * sizeof *service.peer), "the ranks");
    for (size_t i = 0; i < peers; i++) service.peer[i].heartbeat = MPI_REQUEST_NULL;
    if (pthread_create(&service.thread, NULL, serve, NULL) != 0)
        return cml_fail(err, CML_E_IO, "rank %d: the thread that answers other ranks cannot start",
                        cml_ranks.rank);
    return CML_OK;
}

/* Receives the heartbeats (signs of life of other ranks) that were still under way: MPI_Finalize wants every
 * message received. */
static void drain(void)
{
    uint64_t number = 0;
    int from = 0;
    while (receive(TAG_HEARTBEAT, &number, sizeof number, &from)) continue;
    for (int i = first_peer(); i < end_of_peers(); i++)
        MPI_Wait(&service.peer[i].heartbeat, MPI_STATUS_IGNORE);
}

/* Ends the thread, which looks at `leaving` every few milliseconds. Messages are drained afterwards, because
 * two threads must not receive at once. */
void cml_service_stop(void)
{
    atomic_store(&service.leaving, true);
    pthread_join(service.thread, NULL);
    drain();
    free(service.peer);
}

/* ---- synchronisations and requests ---- */

/* Requests the synchronisation after those held so far. Other ranks learn of it by the next heartbeat, which
 * is sent at once. */
void cml_cluster_request_sync(atomic_int *own)
{
    if (atomic_load(&cml_ranks.alone))
        atomic_fetch_or(own, 1);
    else
        cml_cluster_recall();
}

/* Asks all ranks to end what they do alone and to meet. Even numbers of meetings mean no stop. */
void cml_cluster_recall(void)
{
    raise_requested(2 * (atomic_load(&service.syncs_done) + 1));
}

/* True if any rank has requested a synchronisation that was not held yet. */
static bool all_requested(void)
{
    return atomic_load(&service.syncs_requested) / 2 > atomic_load(&service.syncs_done);
}

/* Asks all ranks to meet and then to stop. An odd number of a meeting means a stop. A rank that works alone
 * sets its own flag, bit 1 (value 2). */
void cml_cluster_request_stop(atomic_int *own)
{
    if (atomic_load(&cml_ranks.alone))
        atomic_fetch_or(own, 2);
    else
        raise_requested(2 * (atomic_load(&service.syncs_done) + 1) + 1);
}

/* True if a stop was requested: by the flag of a rank that works alone, or by an odd number of the next
 * meeting. */
bool cml_cluster_stop_requested(atomic_int *own)
{
    if (atomic_load(&cml_ranks.alone)) return atomic_load(own) & 2;
    return all_requested() && atomic_load(&service.syncs_requested) % 2 == 1;
}

void cml_cluster_alone(bool alone)
{
    atomic_store(&cml_ranks.alone, alone);
}

/* True if this rank works alone and was asked to meet the others. */
bool cml_cluster_recalled(void)
{
    return atomic_load(&cml_ranks.alone) && all_requested();
}

/* True if all ranks were asked to meet. */
bool cml_cluster_sync_requested(atomic_int *own)
{
    return atomic_load(&cml_ranks.alone) ? atomic_load(own) != 0 : all_requested();
}

/* Counts a synchronisation as requested on this rank first: another rank may have requested it without this
 * rank having heard. The barrier is the only wait here; the calls that follow are collective anyway. */
cml_status cml_cluster_synchronise(atomic_int *own, struct cml_error *err)
{
    MPI_Request call;
    if (atomic_load(&cml_ranks.alone)) {
        atomic_store(own, 0);
        return CML_OK;
    }
    cml_cluster_recall();
    if (cml_ranks.size > 1) CML_TRY(CML_COMPLETE(MPI_Ibarrier(MPI_COMM_WORLD, &call), &call, err));
    atomic_fetch_add(&service.syncs_done, 1);
    return CML_OK;
}

/* Replaces the function that answers requests of other ranks. Waits until a request under way is answered, so
 * that the caller may free the old handler's data. */
void cml_cluster_set_handler(cml_cluster_handler *handler, void *context)
{
    /* nobody asks a rank that is alone, and rank 0 keeps its handler */
    if (atomic_load(&cml_ranks.alone)) return;
    pthread_mutex_lock(&service.handler_lock);
    service.handler = handler;
    service.handler_context = context;
    pthread_mutex_unlock(&service.handler_lock);
}

/* Sends a request for work to rank 0 and waits for the reply. The receive is posted before the request is
 * sent, so that the reply finds its buffer. */
cml_status cml_cluster_request(const struct cml_work_request *request, struct cml_work_reply *reply,
                               struct cml_error *err)
{
    MPI_Request sent, received;
    pthread_mutex_lock(&cml_ranks.lock);
    int code = MPI_Irecv(reply, sizeof *reply, MPI_BYTE, 0, TAG_REPLY, MPI_COMM_WORLD, &received);
    if (code == MPI_SUCCESS)
        code = MPI_Isend(request, sizeof *request, MPI_BYTE, 0, TAG_REQUEST, MPI_COMM_WORLD, &sent);
    CML_TRY(cml_cluster_complete(code, &sent, err));
    return wait_for(&received, err);
}
