/* SPDX-License-Identifier: MIT */
#include "run/checkpoint.h"

#include "base/atomic_file.h"
#include "base/text.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

/* Layout of a checkpoint file: this head, the identity, a text (the JSON of the record, or the call of a
 * part), the ranges not flown, the summary of the result, its cells, the saved packets, and the CRC-32 of all
 * of these in 64 bits. All members have fixed sizes, and there is no padding. */
struct head {
    char magic[24];
    uint64_t order, version, finished;
    uint64_t identity_size, json_size, num_ranges, num_cells; /* num_cells 0: the file holds no tallies */
    /* saved packets in the file, and how many packets were found that asked to be saved */
    uint64_t num_saved, found;
    uint64_t begin, end;
    double seconds;
    struct cml_part part;
    struct cml_record record; /* the pointer to its JSON is not written: the text stands behind the head */
};
static const char magic[24] = CML_CHECKPOINT_MAGIC;
#define ORDER 0x0102030405060708u /* a machine of the other byte order reads another number */
#define VERSION 17u               /* version of this layout; the program refuses any other */

cml_status cml_checkpoint_path(const char *output, char **path, struct cml_error *err)
{
    return cml_text_format(path, "a path", err, "%s.checkpoint", output);
}

cml_status cml_part_path(const char *output, struct cml_part part, char **path, struct cml_error *err)
{
    return cml_text_format(path, "a path", err, "%s.part%" PRIu64 "of%" PRIu64, output, part.number,
                           part.count);
}

struct cml_range cml_part_turns(struct cml_part part, uint64_t begin, uint64_t end)
{
    const cml_u128 turns = end - begin;
    if (part.count == 0) return (struct cml_range){begin, end - begin};
    const uint64_t first = (uint64_t)(turns * (part.number - 1) / part.count),
                   behind = (uint64_t)(turns * part.number / part.count);
    return (struct cml_range){begin + first, behind - first};
}

/* ---- writing ---- */

/* A file being written and the checksum of all bytes written so far. */
struct sink {
    FILE *stream;
    uLong sum;
};

/* Writes bytes, and adds them to the checksum. */
static void put(struct sink *sink, const void *data, size_t size)
{
    if (!data || size == 0) return; /* crc32_z would start a new checksum for a null pointer */
    /* a write error stays with the stream, and cml_file_commit reports it */
    fwrite(data, 1, size, sink->stream);
    sink->sum = crc32_z(sink->sum, data, size);
}

/* Writes a whole checkpoint: head, identity, text, open ranges, summary, sums, saved packets, checksum. A
 * finished run has a record, whose JSON is the text; otherwise record is NULL and the text is `call`, the
 * command line. result NULL: no sums are kept. */
static void write_all(FILE *stream, const char *identity, const char *call, const struct cml_run_state *state,
                      const struct cml_record *record, struct cml_result *result)
{
    static const struct cml_record unknown; /* of a run that is not finished */
    struct sink sink = {stream, crc32(0, NULL, 0)};
    struct head head = {.order = ORDER,
                        .version = VERSION,
                        .finished = record != NULL,
                        .identity_size = strlen(identity),
                        .begin = state->begin,
                        .end = state->end,
                        .seconds = state->seconds,
                        .part = state->part};
    const char *const text = record ? record->json : call;
    if (!record) record = &unknown;
    static const struct cml_summary none; /* of a rank that has no result */
    size_t cells = 0;
    const cml_u128 *cell = result ? cml_result_cells(result, &cells) : NULL;
    struct cml_saved *const saved = result ? result->saved : NULL;
    const struct cml_saved_sums sums = saved ? cml_saved_sort(saved) : (struct cml_saved_sums){0};
    memcpy(head.magic, magic, sizeof magic);
    head.num_ranges = state->open.count;
    head.num_cells = cells;
    head.num_saved = sums.kept;
    head.found = sums.found;
    head.json_size = text ? strlen(text) : 0;
    head.record = *record;
    head.record.json = NULL;
    put(&sink, &head, sizeof head);
    put(&sink, identity, head.identity_size);
    put(&sink, text, head.json_size);
    put(&sink, state->open.item, state->open.count * sizeof *state->open.item);
    put(&sink, result ? &result->summary : &none, sizeof none);
    put(&sink, cell, cells * sizeof *cell);
    if (sums.kept)
        put(&sink, cml_saved_row(saved, 0), sums.kept * cml_saved_row_bytes(cml_saved_media(saved)));
    const uint64_t sum = sink.sum;
    fwrite(&sum, sizeof sum, 1, stream);
}

/* Writes a checkpoint under `path`. keep: the name that the older file under `path` gets; NULL: the older
 * file is replaced. */
static cml_status write_file(const char *path, const char *keep, const char *identity, const char *call,
                             const struct cml_run_state *state, const struct cml_record *record,
                             struct cml_result *result, struct cml_error *err)
{
    struct cml_file file;
    CML_TRY(cml_file_create(path, &file, err));
    file.keep = keep;
    write_all(file.stream, identity, call, state, record, result);
    return cml_file_commit(&file, err);
}

/* Keeps the file before as "PATH.old": a whole checkpoint is on the disk at any moment, and an older one
 * helps where the newest turns out to be damaged. */
cml_status cml_checkpoint_write(const char *path, const char *identity, const char *call,
                                const struct cml_run_state *state, struct cml_result *result,
                                struct cml_error *err)
{
    CML_FREED char *old = NULL;
    CML_TRY(cml_text_format(&old, "a path", err, "%s.old", path));
    return write_file(path, old, identity, call, state, NULL, result, err);
}

void cml_checkpoint_remove_older(const char *path)
{
    struct cml_error ignored;
    CML_FREED char *old = NULL;
    if (cml_text_format(&old, "a path", &ignored, "%s.old", path) == CML_OK) remove(old);
}

cml_status cml_checkpoint_finish(const char *path, const char *identity, const struct cml_run_state *state,
                                 const struct cml_record *record, struct cml_result *result,
                                 struct cml_error *err)
{
    cml_checkpoint_remove_older(path);
    return write_file(path, NULL, identity, NULL, state, record, result, err);
}

/* Deletes both files. Errors do not matter: a missing file needs no removing, and one that cannot be removed
 * does no harm. */
void cml_checkpoint_remove(const char *path)
{
    remove(path);
    cml_checkpoint_remove_older(path);
}

/* ---- reading ---- */

/* One checkpoint file being read. */
struct source {
    const char *path;
    FILE *stream;
    uint64_t left; /* bytes not read yet, without the checksum at the end */
    struct head head;
    char *identity;
};

/* Fails with CML_E_IO, which makes the reader try the older file. CML_E_INPUT would end the run: an older
 * checkpoint of another run is as wrong as the newer one. */
static cml_status fail_damaged(const struct source *source, const char *what, struct cml_error *err)
{
    return cml_fail(err, CML_E_IO, "%s: the checkpoint is damaged (%s)", source->path, what);
}

/* Reads `count` things of a size; false if the file holds fewer. The counts in the head are not trusted
 * before. */
static bool get(struct source *source, void *data, uint64_t count, size_t size)
{
    if (count > source->left / size || fread(data, size, count, source->stream) != count) return false;
    source->left -= count * size;
    return true;
}

/* Compares the whole file with the checksum at its end, and goes back to the beginning. */
static cml_status check_sum(struct source *source, struct cml_error *err)
{
    enum { BLOCK = 1 << 14 };
    unsigned char block[BLOCK];
    uint64_t stored = 0;
    uLong sum = crc32(0, NULL, 0);
    for (uint64_t left = source->left; left > 0;) {
        const size_t size = left < BLOCK ? left : BLOCK;
        if (fread(block, 1, size, source->stream) != size)
            return fail_damaged(source, "cannot be read to its end", err);
        sum = crc32_z(sum, block, size);
        left -= size;
    }
    if (fread(&stored, sizeof stored, 1, source->stream) != 1) return fail_damaged(source, "cut short", err);
    rewind(source->stream);
    return stored == sum ? CML_OK : fail_damaged(source, "checksum", err);
}

/* Reads head and identity. The checksum was right before, so a mismatch here means that another program, or
 * another version, wrote the file. The identity gets a closing zero, which the file does not hold. */
static cml_status read_head(struct source *source, struct cml_error *err)
{
    struct head *head = &source->head;
    if (!get(source, head, 1, sizeof *head) || memcmp(head->magic, magic, sizeof magic) != 0)
        return cml_fail(err, CML_E_INPUT, "%s: is no checkpoint", source->path);
    if (head->order != ORDER || head->version != VERSION)
        return cml_fail(
            err, CML_E_INPUT,
            "%s: another version of clustermcml or another kind of machine wrote the checkpoint (expected "
            "format %u; go on with that program, or begin anew without --resume or --more)",
            source->path, VERSION);
    if (head->identity_size > source->left) return fail_damaged(source, "its identity", err);
    CML_TRY(cml_zeros(&source->identity, head->identity_size + 1, 1, "a checkpoint", err));
    return get(source, source->identity, head->identity_size, 1) ? CML_OK
                                                                 : fail_damaged(source, "cut short", err);
}

/* Returns where the size and checksum begin in an identity's line about an input file: "53 bytes, crc32 ..."
 * in "input x.mci of 53 bytes, crc32 ...". NULL for any other line. */
static const char *find_size(const char *line)
{
    const char *size = NULL;
    const bool is_input = strncmp(line, "input ", 6) == 0;
    for (const char *at = line; is_input && *at && *at != '\n'; at++)
        if (strncmp(at, " of ", 4) == 0) size = at + 4;
    return size;
}

/* For an input file of the same name, the message says that its contents differ. */
cml_status cml_fail_other_run(const char *path, const char *theirs, const char *mine, const char *expected,
                              struct cml_error *err)
{
    while (*theirs && *mine) {
        const size_t m = strcspn(mine, "\n"), t = strcspn(theirs, "\n");
        if (m != t || memcmp(mine, theirs, m) != 0) break;
        mine += m + 1;
        theirs += t + 1;
    }
    const char *size = find_size(mine), *their_size = find_size(theirs);
    if (size && their_size && size - mine == their_size - theirs &&
        memcmp(mine, theirs, (size_t)(size - mine)) == 0)
        return cml_fail(err, CML_E_INPUT,
                        "%s: the checkpoint is of another run: the file %.*s has other contents, %.*s there, "
                        "%.*s here (expected %s)",
                        path, (int)(size - mine - 10), mine + 6, (int)strcspn(their_size, ","), their_size,
                        (int)strcspn(size, ","), size, expected);
    return cml_fail(err, CML_E_INPUT,
                    "%s: the checkpoint is of another run: '%.*s' there, '%.*s' here (expected %s)", path,
                    (int)strcspn(theirs, "\n"), theirs, (int)strcspn(mine, "\n"), mine, expected);
}

/* Refuses a checkpoint of another run. */
static cml_status check_identity(const struct source *source, const char *mine, struct cml_error *err)
{
    if (strcmp(source->identity, mine) == 0) return CML_OK;
    return cml_fail_other_run(source->path, source->identity, mine,
                              "that run; without --resume or --more this one begins anew", err);
}

/* Checks only that the round is not empty and below 2^48 photons; run.c knows which rounds the run has. */
static bool is_round(uint64_t begin, uint64_t end)
{
    return begin < end && end <= (uint64_t)1 << 48;
}

/* Checks the numbers of a part: both are 0 for a whole run. */
static bool is_part(struct cml_part part)
{
    return part.count == 0 ? part.number == 0 : part.number >= 1 && part.number <= part.count;
}

/* Orders ranges of photons by their first photon. */
static int compare_ranges(const void *a, const void *b)
{
    const uint64_t one = ((const struct cml_range *)a)->first, other = ((const struct cml_range *)b)->first;
    return (one > other) - (one < other);
}

/* True if the open ranges are disjoint parts of the round and all other indices of the round are in the
 * summary. ranges: sorted by their first index. */
static bool are_ranges_sound(const struct cml_range *ranges, uint64_t count, const struct head *head,
                             const struct cml_summary *summary)
{
    uint64_t from = head->begin, open = 0;
    for (uint64_t i = 0; i < count; i++) {
        if (ranges[i].first < from || ranges[i].first >= head->end || ranges[i].count == 0 ||
            ranges[i].count > head->end - ranges[i].first)
            return false;
        from = ranges[i].first + ranges[i].count;
        open += ranges[i].count;
    }
    const uint64_t before = head->part.count > 0 ? head->begin : 0;
    return summary->count[CML_COUNT_PHOTONS] == head->end - before - open;
}

/* True if the indices of lost packets rise, and are below `end`. */
static bool is_lost_list_sound(const struct cml_lost_list *lost, uint64_t end)
{
    if (lost->count < 0 || lost->count > CML_LOST_LISTED) return false;
    for (int i = 0; i < lost->count; i++)
        if (lost->index[i] >= end || (i > 0 && lost->index[i] <= lost->index[i - 1])) return false;
    return true;
}

/* Checks the ranges of photons not flown yet: sorted, none may overlap, and with the flown ones they must
 * make up the round. A copy is sorted, because ranges are taken in the file's order. */
static cml_status check_ranges(const struct source *source, const struct cml_ranges *open,
                               const struct cml_summary *summary, struct cml_error *err)
{
    CML_FREED struct cml_range *sorted = NULL;
    CML_TRY(cml_zeros(&sorted, open->count, sizeof *sorted, "a checkpoint's ranges", err));
    if (open->count > 0) memcpy(sorted, open->item, open->count * sizeof *sorted);
    qsort(sorted, open->count, sizeof *sorted, compare_ranges);
    const bool good = are_ranges_sound(sorted, open->count, &source->head, summary);
    return good ? CML_OK : fail_damaged(source, "its ranges of photons", err);
}

/* Reads the open ranges through cml_ranges_add, which counts their total anew. */
static cml_status read_ranges(struct source *source, struct cml_ranges *ranges, struct cml_error *err)
{
    for (uint64_t i = 0; i < source->head.num_ranges; i++) {
        struct cml_range range;
        if (!get(source, &range, 1, sizeof range)) return fail_damaged(source, "cut short", err);
        if (range.count == 0) return fail_damaged(source, "its ranges of photons", err);
        CML_TRY(cml_ranges_add(ranges, range, err));
    }
    return CML_OK;
}

/* Reads the saved packets. They must come in rising order of index, none twice, and no more than the limit;
 * else the file is damaged. */
static cml_status read_saved(struct source *source, struct cml_saved *saved, struct cml_error *err)
{
    const struct head *head = &source->head;
    const size_t size = saved ? cml_saved_row_bytes(cml_saved_media(saved)) : 0;
    if (head->found < head->num_saved || head->found > head->end || (head->found && !saved))
        return fail_damaged(source, "its saved photons", err);
    CML_FREED uint64_t *row = NULL;
    CML_TRY(cml_zeros(&row, size, 1, "a saved photon", err));
    uint64_t least = 0;
    if (saved) cml_saved_clear(saved);
    for (uint64_t i = 0; i < head->num_saved; i++) {
        if (!get(source, row, 1, size) || *row < least || !cml_saved_may_have(saved, *row, head->end))
            return fail_damaged(source, "its saved photons", err);
        least = *row + 1;
        cml_saved_add(saved, row, 1);
    }
    if (saved) cml_saved_add_found(saved, head->found - head->num_saved);
    return CML_OK;
}

/* Reads the sums of a run from a checkpoint: its round, the photons not flown yet, summary, cells and saved
 * packets. The identity fixes grid and photons, so a sound file has the same number of cells. */
static cml_status read_tallies(struct source *source, struct cml_run_state *state, struct cml_result *result,
                               struct cml_error *err)
{
    const struct head *head = &source->head;
    size_t cells = 0;
    cml_u128 *cell = cml_result_cells(result, &cells);
    if (!is_round(head->begin, head->end) || !is_part(head->part) ||
        !(head->seconds >= 0 && isfinite(head->seconds)))
        return fail_damaged(source, "its head", err);
    state->begin = head->begin;
    state->end = head->end;
    state->seconds = head->seconds;
    state->part = head->part;
    CML_TRY(read_ranges(source, &state->open, err));
    if (head->num_cells != cells || !get(source, &result->summary, 1, sizeof result->summary) ||
        !get(source, cell, cells, sizeof *cell))
        return fail_damaged(source, "its grid", err);
    CML_TRY(read_saved(source, result->saved, err));
    if (source->left > 0) return fail_damaged(source, "its grid", err);
    if (!is_lost_list_sound(&result->summary.lost, head->end))
        return fail_damaged(source, "its lost packets", err);
    return check_ranges(source, &state->open, &result->summary, err);
}

/* The run whose checkpoint is wanted, and where its contents go. */
struct wanted {
    const char *identity;
    enum cml_checkpoint_kind *kind;
    struct cml_run_state *state;
    struct cml_result *result;
    bool tallies; /* read the tallies of a finished run, too */
    struct cml_record *record;
};

/* Reads the record. It is empty in the checkpoint of a run that is not finished. */
static cml_status read_record(struct source *source, struct cml_record *record, struct cml_error *err)
{
    const struct head *head = &source->head;
    cml_record_clear(record);
    if (head->json_size > source->left || !cml_record_is_sound(&head->record))
        return fail_damaged(source, "its record", err);
    *record = head->record;
    CML_TRY(cml_zeros(&record->json, head->json_size + 1, 1, "a checkpoint", err));
    return get(source, record->json, head->json_size, 1) ? CML_OK : fail_damaged(source, "cut short", err);
}

/* Reads one file: checksum, head, identity, record, tallies. The order matters: the identity means something
 * only where the checksum is right, and the tallies only where the identity is that of this run. */
static cml_status read_source(struct source *source, const struct wanted *wanted, struct cml_error *err)
{
    const struct head *head = &source->head;
    CML_TRY(check_sum(source, err));
    CML_TRY(read_head(source, err));
    CML_TRY(check_identity(source, wanted->identity, err));
    CML_TRY(read_record(source, wanted->record, err));
    *wanted->kind = head->finished ? CML_CHECKPOINT_FINISHED : CML_CHECKPOINT_PARTIAL;
    if (head->finished && !wanted->tallies) return CML_OK;
    if (head->finished && head->num_cells == 0)
        return cml_fail(err, CML_E_INPUT, "%s: has no tallies (expected those of a run with --keep)",
                        source->path);
    return read_tallies(source, wanted->state, wanted->result, err);
}

/* Opens a checkpoint, which must be a regular file: a pipe or a device has no known end. O_NONBLOCK, because
 * opening a pipe must not wait for a writer. */
static cml_status open_source(struct source *source, struct cml_error *err)
{
    struct stat about;
    const int file = open(source->path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) return cml_fail(err, CML_E_IO, "%s: cannot be read (%s)", source->path, strerror(errno));
    if (fstat(file, &about) != 0 || !S_ISREG(about.st_mode)) {
        close(file);
        return cml_fail(err, CML_E_INPUT, "%s: is no checkpoint (expected a regular file)", source->path);
    }
    if (about.st_size < (off_t)sizeof(uint64_t)) {
        close(file);
        return fail_damaged(source, "cut short", err);
    }
    source->left = (uint64_t)about.st_size - sizeof(uint64_t);
    source->stream = fdopen(file, "rb");
    return source->stream ? CML_OK : cml_fail_memory(err, BUFSIZ, "a checkpoint");
}

/* Reads one of the two files; *wanted->kind is CML_CHECKPOINT_NONE where it does not exist. CML_E_IO: the
 * file is damaged or unreadable, and the older one may help. */
static cml_status read_one(const char *path, const struct wanted *wanted, struct cml_error *err)
{
    struct source source = {.path = path};
    *wanted->kind = CML_CHECKPOINT_NONE;
    if (access(path, F_OK) != 0 && errno == ENOENT) return CML_OK;
    CML_TRY(open_source(&source, err));
    const cml_status status = read_source(&source, wanted, err);
    fclose(source.stream);
    free(source.identity);
    return status;
}

/* Reads "PATH.old". `note` holds why the newer file was not used, or is empty. On success the note becomes
 * the line that tells the user which file the run continues from; without an older file it becomes the error.
 */
static cml_status read_older(const char *path, const struct wanted *wanted, struct cml_error *note,
                             struct cml_error *err)
{
    struct cml_error why = *note;
    const bool damaged = why.text[0] != '\0';
    cml_ranges_clear(&wanted->state->open); /* the damaged file may have left ranges there */
    CML_TRY(read_one(path, wanted, err));
    if (*wanted->kind != CML_CHECKPOINT_NONE)
        note->status = cml_fail(note, CML_OK, "%s%scontinuing from %s", why.text, damaged ? "; " : "", path);
    if (*wanted->kind == CML_CHECKPOINT_NONE && damaged)
        return cml_fail(err, CML_E_INPUT, "%s, and there is no older one", why.text);
    return CML_OK;
}

cml_status cml_checkpoint_read(const char *path, const char *identity, enum cml_checkpoint_kind *kind,
                               struct cml_run_state *state, struct cml_result *result, bool tallies,
                               struct cml_record *record, struct cml_error *note, struct cml_error *err)
{
    const struct wanted wanted = {identity, kind, state, result, tallies, record};
    *note = (struct cml_error){CML_OK, ""};
    cml_status status = read_one(path, &wanted, err);
    if (status == CML_E_IO)
        *note = *err;
    else if (status != CML_OK || *kind != CML_CHECKPOINT_NONE)
        return status;
    CML_FREED char *old = NULL;
    CML_TRY(cml_text_format(&old, "a path", err, "%s.old", path));
    status = read_older(old, &wanted, note, err);
    return status == CML_E_IO ? CML_E_INPUT : status;
}

/* Returns what the head of a checkpoint says: finished or not, with sums or not, the round, and the part. */
static struct cml_checkpoint_about about_of(const struct head *head)
{
    return (struct cml_checkpoint_about){head->finished ? CML_CHECKPOINT_FINISHED : CML_CHECKPOINT_PARTIAL,
                                         head->num_cells > 0, head->begin, head->end, head->part};
}

struct cml_checkpoint_about cml_checkpoint_look(const char *path)
{
    struct cml_checkpoint_about about = {.kind = CML_CHECKPOINT_NONE};
    struct source source = {.path = path};
    struct cml_error ignored;
    if (open_source(&source, &ignored) != CML_OK) return about;
    if (read_head(&source, &ignored) == CML_OK) about = about_of(&source.head);
    fclose(source.stream);
    free(source.identity);
    return about;
}

/* Reads the head and the command line of the file of a part, and refuses any other file. */
static cml_status read_part(struct source *source, struct cml_record *record, struct cml_error *err)
{
    const struct head *head = &source->head;
    if (read_head(source, err) != CML_OK || head->part.count == 0 || !is_part(head->part) ||
        !is_round(head->begin, head->end))
        return cml_fail(err, CML_E_INPUT,
                        "%s: is no part of a run (expected a file that run --part of this version wrote)",
                        source->path);
    return read_record(source, record, err);
}

cml_status cml_part_look(const char *path, struct cml_checkpoint_about *about, char **identity, char **call,
                         struct cml_error *err)
{
    struct cml_record record = {0};
    struct source source = {.path = path};
    cml_status status = open_source(&source, err);
    if (status == CML_OK) status = read_part(&source, &record, err);
    if (source.stream) fclose(source.stream);
    if (status != CML_OK) {
        free(source.identity);
        cml_record_clear(&record);
        return CML_E_INPUT;
    }
    *about = about_of(&source.head);
    *identity = source.identity;
    *call = record.json;
    return CML_OK;
}
