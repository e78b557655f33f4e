/* SPDX-License-Identifier: MIT */
#include "flights/sweep_rows.h"

#include "run/cluster/cluster.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

cml_status cml_sweep_rows_create(int count, struct cml_sweep_rows *rows, struct cml_error *err)
{
    *rows = (struct cml_sweep_rows){.count = count};
    CML_TRY(cml_zeros(&rows->done, (size_t)count, sizeof *rows->done, "the rows", err));
    return cml_zeros(&rows->record, (size_t)count, sizeof *rows->record, "the rows", err);
}

void cml_sweep_rows_clear(struct cml_sweep_rows *rows)
{
    for (int i = 0; rows->record && i < rows->count; i++) cml_record_clear(&rows->record[i]);
    free(rows->done);
    free(rows->record);
    *rows = (struct cml_sweep_rows){0};
}

/* Flies one row. A row whose weights do not balance is written, and the other rows are still flown. */
static cml_status fly_one(struct cml_sweep_rows *rows, int row, cml_sweep_fly_function *fly, void *context,
                          cml_status *worst, struct cml_error *err)
{
    struct cml_error why;
    const cml_status status = fly(context, row, &rows->record[row], &why);
    rows->done[row] = status == CML_OK || status == CML_E_NUMERIC;
    if (status != CML_OK) *err = why;
    if (status == CML_E_NUMERIC) *worst = status;
    return rows->done[row] ? CML_OK : status;
}

/* Prints the JSON record of a row on rank 0, and frees it on all ranks. */
static void print_json(struct cml_record *record, bool json)
{
    if (json && record->json && cml_cluster_rank() == 0) {
        fputs(record->json, stdout);
        fflush(stdout);
    }
    free(record->json);
    record->json = NULL;
}

void cml_sweep_rows_print(struct cml_sweep_rows *rows, bool json)
{
    for (int row = 0; row < rows->count; row++) print_json(&rows->record[row], json);
}

/* Flies the rows one after the other, each on all ranks. json: prints each row's record at once. */
static cml_status fly_together(struct cml_sweep_rows *rows, bool json, cml_sweep_fly_function *fly,
                               void *context, struct cml_error *err)
{
    cml_status worst = CML_OK;
    for (int row = 0; row < rows->count; row++) {
        CML_TRY(fly_one(rows, row, fly, context, &worst, err));
        print_json(&rows->record[row], json);
        rows->num_done++;
    }
    return worst;
}

/* ---- rows shared among ranks ---- */

/* The rows that nobody has taken yet. Rank 0 takes rows itself, and its service thread gives them to other
 * ranks. */
struct row_queue {
    atomic_int next;
    atomic_bool closed;
    int count;
};

/* Returns the next row; -1: there are no more, or the rows are to end. */
static int hand_out(struct row_queue *queue)
{
    if (atomic_load(&queue->closed) || cml_cluster_recalled()) return -1;
    const int row = atomic_fetch_add(&queue->next, 1);
    return row < queue->count ? row : -1;
}

/* Gives the next row to another rank that asks for one. It is the cml_cluster_handler of rank 0. */
static void reply_to(void *context, int rank, const struct cml_work_request *request,
                     struct cml_work_reply *reply)
{
    (void)rank, (void)request;
    const int row = hand_out(context);
    reply->first = row >= 0 ? (uint64_t)row : 0;
    reply->count = row >= 0;
}

/* Gives a rank its next row to fly; *row is -1 when there are no more. */
static cml_status take_row(struct row_queue *queue, int rank, int *row, struct cml_error *err)
{
    const struct cml_work_request request = {1, 0};
    struct cml_work_reply reply = {0};
    *row = -1;
    if (rank == 0) {
        *row = hand_out(queue);
        return CML_OK;
    }
    CML_TRY(cml_cluster_request(&request, &reply, err));
    if (reply.count > 0) *row = (int)reply.first;
    return CML_OK;
}

/* Flies rows on this rank alone until there are no more. A failure or a signal here makes the other ranks
 * end, too. */
static cml_status fly_alone(struct cml_sweep_rows *rows, struct row_queue *queue, int rank,
                            cml_sweep_fly_function *fly, void *context, struct cml_error *err)
{
    cml_status status = CML_OK, worst = CML_OK;
    cml_cluster_alone(true);
    for (int row = 0; status == CML_OK;) {
        status = take_row(queue, rank, &row, err);
        if (status != CML_OK || row < 0) break;
        status = fly_one(rows, row, fly, context, &worst, err);
    }
    if (rank == 0) atomic_store(&queue->closed, true);
    if (status != CML_OK) cml_cluster_recall();
    cml_cluster_alone(false);
    return status != CML_OK ? status : worst;
}

/* Report of a row to rank 0; it has no pointers. */
struct row_report {
    uint64_t done, json_size;
    struct cml_record record;
};

/* Fills this rank's report about every row: whether it was flown here, and its record without the text. */
static void fill_reports(const struct cml_sweep_rows *rows, struct row_report *mine)
{
    for (int i = 0; i < rows->count; i++) {
        mine[i] = (struct row_report){.done = rows->done[i], .record = rows->record[i]};
        mine[i].json_size = rows->record[i].json ? strlen(rows->record[i].json) : 0;
        mine[i].record.json = NULL;
    }
}

/* Returns the bytes of the JSON objects of a rank's first `count` rows. */
static size_t json_total(const struct row_report *report, int count)
{
    size_t total = 0;
    for (int i = 0; i < count; i++) total += report[i].json_size;
    return total;
}

/* Joins the JSON records of the rows that this rank has flown into one text. */
static void join_json(const struct cml_sweep_rows *rows, char *text)
{
    for (int i = 0; i < rows->count; i++) {
        const char *json = rows->record[i].json;
        if (!json) continue;
        memcpy(text, json, strlen(json));
        text += strlen(json);
    }
}

/* Prints the JSON objects of all rows, on rank 0, in the order of rows. text: the joined objects of each
 * rank, `size` bytes apart. */
static void print_all(const struct cml_sweep_rows *rows, const struct row_report *all, const char *text,
                      size_t size)
{
    const int ranks = cml_cluster_size();
    for (int i = 0; i < rows->count; i++)
        for (int r = 0; r < ranks; r++) {
            const struct row_report *of_rank = all + (size_t)r * (size_t)rows->count;
            if (of_rank[i].json_size == 0) continue;
            const char *begin = text + (size_t)r * size + json_total(of_rank, i);
            fwrite(begin, 1, of_rank[i].json_size, stdout);
        }
    fflush(stdout);
}

/* Collects the JSON records of all rows on rank 0 and prints them in the order of rows. All ranks send texts
 * of equal size, that of the longest. */
static cml_status gather_json(const struct cml_sweep_rows *rows, const struct row_report *all,
                              struct cml_error *err)
{
    const bool first = cml_cluster_rank() == 0;
    uint64_t size = 1;
    for (int r = 0; first && r < cml_cluster_size(); r++) {
        const size_t total = json_total(all + (size_t)r * (size_t)rows->count, rows->count);
        if (total > size) size = total;
    }
    CML_TRY(cml_cluster_share(&size, sizeof size, err));
    CML_FREED char *text = NULL, *texts = NULL;
    cml_status status = cml_zeros(&text, size, 1, "the JSON records", err);
    if (status == CML_OK && first)
        status = cml_zeros(&texts, size, (size_t)cml_cluster_size(), "the JSON records", err);
    CML_TRY(cml_cluster_agree(status, err));
    join_json(rows, text);
    CML_TRY(cml_cluster_gather(text, size, texts, err));
    if (first) print_all(rows, all, texts, size);
    return CML_OK;
}

/* Takes over the records of rows that other ranks have flown, on rank 0. */
static void take_over(struct cml_sweep_rows *rows, const struct row_report *all)
{
    for (int i = 0; i < rows->count; i++) {
        for (int r = 0; r < cml_cluster_size(); r++) {
            const struct row_report *report = &all[(size_t)r * (size_t)rows->count + (size_t)i];
            if (!report->done || rows->done[i]) continue;
            rows->done[i] = true;
            rows->record[i] = report->record;
        }
        rows->num_done += rows->done[i];
    }
}

/* Gathers the rows of all ranks on rank 0. Ranks wait for each other here for the first time since the flight
 * began. */
static cml_status gather(struct cml_sweep_rows *rows, bool json, struct cml_error *err)
{
    const size_t count = (size_t)rows->count;
    const size_t ranks = cml_cluster_rank() == 0 ? (size_t)cml_cluster_size() : 1;
    CML_FREED struct row_report *mine = NULL, *all = NULL;
    cml_status status = cml_zeros(&mine, count, sizeof *mine, "the rows", err);
    if (status == CML_OK) status = cml_zeros(&all, ranks * count, sizeof *all, "the rows", err);
    CML_TRY(cml_cluster_agree(status, err));
    fill_reports(rows, mine);
    CML_TRY(cml_cluster_gather(mine, count * sizeof *mine, all, err));
    if (json) CML_TRY(gather_json(rows, all, err));
    if (cml_cluster_rank() == 0) take_over(rows, all);
    return CML_OK;
}

/* Flies rows on all ranks at once, each rank another row: it takes the next one when it has finished one. */
static cml_status fly_shared(struct cml_sweep_rows *rows, bool json, cml_sweep_fly_function *fly,
                             void *context, struct cml_error *err)
{
    struct row_queue queue = {.count = rows->count};
    struct cml_error why = {CML_OK, ""};
    const int rank = cml_cluster_rank();
    if (rank == 0) cml_cluster_set_handler(reply_to, &queue);
    const cml_status flown = fly_alone(rows, &queue, rank, fly, context, &why);
    const cml_status status = gather(rows, json, err);
    if (rank == 0) cml_cluster_set_handler(NULL, NULL);
    CML_TRY(status);
    *err = why;
    return cml_cluster_agree(flown, err);
}

cml_status cml_sweep_rows_fly(struct cml_sweep_rows *rows, bool json, cml_sweep_fly_function *fly,
                              void *context, struct cml_error *err)
{
    return rows->count > cml_cluster_size() && cml_cluster_size() > 1
               ? fly_shared(rows, json, fly, context, err)
               : fly_together(rows, json, fly, context, err);
}
