/* SPDX-License-Identifier: MIT */
#include "run/cluster/cluster_parts.h"

#include "run/cluster/launcher.h"

#include <stdlib.h>
#include <string.h>

/* cells of one slice of a sum: 4 MiB keep the buffers inside MPI small */
#define SLICE_CELLS ((size_t)1 << 18)
/* bytes of one slice of a block sent to all ranks: MPI counts with an int */
#define SLICE_BYTES ((size_t)64 << 20)

struct cml_ranks cml_ranks = {.size = 1, .timeout = 60, .lost_rank = -1, .lock = PTHREAD_MUTEX_INITIALIZER};

/* This process among the ranks of its machine. */
static struct {
    int rank, size; /* rank and number of ranks on this machine */
    int fair_cores;
} local = {.size = 1};

static struct {
    MPI_Datatype cell, summary;
    MPI_Op add_cells, add_summary;
} types;

/* ---- beginning and end ---- */

/* Sums of cells (128-bit integers) and of summaries are operations of our own, because MPI has no integers of
 * 128 bits. To MPI their types are bytes. Both operations commute, as MPI_Op_create is told. */

/* Adds 128-bit sums of one rank to those of another, for MPI_Reduce; MPI itself has no 128-bit numbers. */
static void add_cells(void *in, void *inout, int *count, MPI_Datatype *type)
{
    (void)type;
    for (size_t i = 0; i < (size_t)*count; i++) { /* copied, because MPI promises no alignment */
        cml_u128 from, to;
        memcpy(&from, (const char *)in + i * sizeof from, sizeof from);
        memcpy(&to, (char *)inout + i * sizeof to, sizeof to);
        to += from;
        memcpy((char *)inout + i * sizeof to, &to, sizeof to);
    }
}

/* Adds the summaries (balance, counts, lost packets) of one rank to those of another, for MPI_Reduce. */
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

/* Makes types of whole cells and whole summaries: MPI may cut a message between two elements, but not within
 * one. */
static void create_types(void)
{
    MPI_Type_contiguous(sizeof(cml_u128), MPI_BYTE, &types.cell);
    MPI_Type_contiguous(sizeof(struct cml_summary), MPI_BYTE, &types.summary);
    MPI_Type_commit(&types.cell);
    MPI_Type_commit(&types.summary);
    MPI_Op_create(add_cells, 1, &types.add_cells);
    MPI_Op_create(add_summaries, 1, &types.add_summary);
}

/* Sets this rank's even share of the cores that the machine's ranks may run on together; no more than this
 * rank may use itself. */
static void share_cores(MPI_Comm machine)
{
    struct cml_cores mine, all;
    cml_cores_mine(&mine);
    MPI_Allreduce(&mine, &all, sizeof mine, MPI_BYTE, MPI_BOR, machine);
    const int share = cml_cores_count(&all) / local.size, most = cml_cores_count(&mine);
    local.fair_cores = share < 1 ? 1 : share < most ? share : most;
}

/* Finds the ranks that share this machine, and the names of all hosts, for messages. The service thread does
 * not run yet, so these calls may block. */
static void find_machine(void)
{
    MPI_Comm machine;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, cml_ranks.rank, MPI_INFO_NULL, &machine);
    MPI_Comm_rank(machine, &local.rank);
    MPI_Comm_size(machine, &local.size);
    share_cores(machine);
    MPI_Comm_free(&machine);
    char name[MPI_MAX_PROCESSOR_NAME] = "", host[CML_HOST_SIZE] = "";
    int length = 0;
    MPI_Get_processor_name(name, &length);
    memcpy(host, name, sizeof host - 1);
    MPI_Allgather(host, sizeof host, MPI_BYTE, cml_ranks.host, sizeof host, MPI_BYTE, MPI_COMM_WORLD);
}

/* Sets up a cluster of several ranks. Errors of MPI return a code instead of ending the process, so that a
 * message can be printed and no output is lost. */
static cml_status join_world(struct cml_error *err)
{
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    cml_ranks.host = calloc((size_t)cml_ranks.size, CML_HOST_SIZE);
    if (!cml_ranks.host) return cml_fail_memory(err, cml_ranks.size * 64.0, "the ranks");
    create_types();
    find_machine();
    return cml_service_start(err);
}

/* Begins MPI if a launcher has started the program; without a launcher MPI is not even initialised. A single
 * rank under a launcher gets no service thread. */
cml_status cml_cluster_begin(int *argc, char ***argv, struct cml_error *err)
{
    if (!cml_launcher_found()) return cml_launcher_check(1, NULL, err);
    int level = 0;
    if (MPI_Init_thread(argc, argv, MPI_THREAD_SERIALIZED, &level) != MPI_SUCCESS)
        return cml_fail(err, CML_E_DEVICE, "MPI cannot start");
    MPI_Comm_rank(MPI_COMM_WORLD, &cml_ranks.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &cml_ranks.size);
    cml_status status = cml_launcher_check(cml_ranks.size, NULL, err);
    if (status == CML_OK && level < MPI_THREAD_SERIALIZED)
        status = cml_fail(err, CML_E_DEVICE, "this MPI library does not support MPI_THREAD_SERIALIZED");
    return status == CML_OK && cml_ranks.size > 1 ? join_world(err) : status;
}

/* Waits before MPI_Abort. Aborting at once would be slower: when mpiexec is told to end the ranks of a lost
 * host before it has noticed the loss itself, it waits for the host's answer until TCP gives up, a quarter of
 * an hour. Its daemon on the lost host does the same. */
void cml_cluster_await_launcher(void)
{
    for (double waited = 0; waited < 2 * cml_ranks.timeout; waited += 0.1) cml_cluster_sleep(0.1);
}

void cml_cluster_end(cml_status status)
{
    int begun = 0;
    MPI_Initialized(&begun);
    if (!begun) return;
    if (cml_cluster_contact_lost()) MPI_Abort(MPI_COMM_WORLD, (int)status);
    if (cml_ranks.size > 1) {
        cml_service_stop();
        free(cml_ranks.host);
    }
    MPI_Finalize();
}

/* True if this rank has no other rank to talk to. */
static bool is_single(void)
{
    return cml_ranks.size == 1 || atomic_load(&cml_ranks.alone);
}

/* Returns the number of this rank; 0 while it works alone. */
int cml_cluster_rank(void)
{
    return atomic_load(&cml_ranks.alone) ? 0 : cml_ranks.rank;
}

/* Returns the number of ranks; 1 while this rank works alone. */
int cml_cluster_size(void)
{
    return atomic_load(&cml_ranks.alone) ? 1 : cml_ranks.size;
}

int cml_cluster_local_rank(void)
{
    return local.rank;
}

int cml_cluster_local_size(void)
{
    return local.size;
}

int cml_cluster_fair_cores(void)
{
    return local.fair_cores;
}

void cml_cluster_set_timeout(double seconds)
{
    cml_ranks.timeout = seconds;
}

bool cml_cluster_contact_lost(void)
{
    return atomic_load(&cml_ranks.lost_rank) >= 0;
}

/* ---- together ---- */

/* Returns the worst status of all ranks on all ranks, with its message. MPI_MAXLOC finds the largest status
 * and the lowest rank that has it, which then sends its message. After contact is lost, every rank returns
 * its own status. */
cml_status cml_cluster_agree(cml_status mine, struct cml_error *err)
{
    if (is_single()) return mine;
    if (cml_cluster_contact_lost()) return mine != CML_OK ? mine : cml_cluster_fail_contact_lost(err);
    struct {
        int status, rank;
    } worst = {(int)mine, cml_ranks.rank};
    MPI_Request call;
    CML_TRY(CML_COMPLETE(MPI_Iallreduce(MPI_IN_PLACE, &worst, 1, MPI_2INT, MPI_MAXLOC, MPI_COMM_WORLD, &call),
                         &call, err));
    if (worst.status == CML_OK) return CML_OK;
    CML_TRY(
        CML_COMPLETE(MPI_Ibcast(err, sizeof *err, MPI_BYTE, worst.rank, MPI_COMM_WORLD, &call), &call, err));
    return (cml_status)worst.status;
}

/* Copies `size` bytes of rank 0 to all ranks: in slices, because MPI counts with an int. */
cml_status cml_cluster_share(void *data, size_t size, struct cml_error *err)
{
    MPI_Request call;
    char *bytes = data;
    for (size_t done = 0; !is_single() && done < size; done += SLICE_BYTES) {
        const size_t count = size - done < SLICE_BYTES ? size - done : SLICE_BYTES;
        CML_TRY(CML_COMPLETE(MPI_Ibcast(bytes + done, (int)count, MPI_BYTE, 0, MPI_COMM_WORLD, &call), &call,
                             err));
    }
    return CML_OK;
}

/* Sends a block from rank 0 to all ranks, which allocate it. The size goes first, and all ranks agree that
 * they have the memory. */
cml_status cml_cluster_share_block(char **block, size_t *size, struct cml_error *err)
{
    cml_status status = CML_OK;
    if (is_single()) return CML_OK;
    CML_TRY(cml_cluster_share(size, sizeof *size, err));
    if (cml_ranks.rank != 0) {
        *block = malloc(*size);
        if (!*block) status = cml_fail_memory(err, (double)*size, "what rank 0 sends");
    }
    CML_TRY(cml_cluster_agree(status, err));
    return cml_cluster_share(*block, *size, err);
}

/* Gathers a block of each rank on rank 0, with one call of MPI, because the blocks are small (a report per
 * rank). */
cml_status cml_cluster_gather(const void *mine, size_t size, void *all, struct cml_error *err)
{
    if (is_single()) {
        memcpy(all, mine, size);
        return CML_OK;
    }
    MPI_Request call;
    return CML_COMPLETE(
        MPI_Igather(mine, (int)size, MPI_BYTE, all, (int)size, MPI_BYTE, 0, MPI_COMM_WORLD, &call), &call,
        err);
}

/* Adds elements of all ranks into those of rank 0. MPI wants MPI_IN_PLACE from rank 0, and a buffer from the
 * others. */
static cml_status sum_elements(void *elements, int count, MPI_Datatype type, MPI_Op op, struct cml_error *err)
{
    MPI_Request call;
    const void *from = cml_ranks.rank == 0 ? MPI_IN_PLACE : elements;
    return CML_COMPLETE(MPI_Ireduce(from, elements, count, type, op, 0, MPI_COMM_WORLD, &call), &call, err);
}

/* Adds the results of all ranks on rank 0, in slices: MPI would otherwise hold a second copy of the result,
 * which may fill half of the memory. */
cml_status cml_cluster_sum(struct cml_result *result, struct cml_error *err)
{
    if (is_single()) return CML_OK;
    size_t cells = 0;
    cml_u128 *cell = cml_result_cells(result, &cells);
    for (size_t done = 0; done < cells; done += SLICE_CELLS) {
        const size_t count = cells - done < SLICE_CELLS ? cells - done : SLICE_CELLS;
        CML_TRY(sum_elements(cell + done, (int)count, types.cell, types.add_cells, err));
    }
    CML_TRY(sum_elements(&result->summary, 1, types.summary, types.add_summary, err));
    if (cml_ranks.rank != 0) {
        memset(cell, 0, cells * sizeof *cell);
        memset(&result->summary, 0, sizeof result->summary);
    }
    return CML_OK;
}
