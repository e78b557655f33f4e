/* SPDX-License-Identifier: MIT */
#include "tally/saved.h"

#include <stdlib.h>
#include <string.h>

/* The position of a row before rows are moved. Rows of the smallest orders are kept. */
struct key {
    uint64_t order, at;
};

/* Saved packets in rows, and keys to sort them. */
struct cml_saved {
    size_t media, words, limit, capacity, count;
    uint64_t beams, found;
    uint64_t last;   /* largest order of a row that is still wanted */
    uint64_t *row;   /* [capacity + 1][words] rows; the last one is spare */
    struct key *key; /* [capacity] keys for sorting */
};

#define PART_WORDS ((size_t)1 << 13) /* words of a thread's buffer, but at least one row */

/* Returns the length of a row in words. Rows begin on a word and are whole words long. */
static size_t words_of(size_t media)
{
    const size_t word = sizeof(uint64_t), of_medium = 2 * sizeof(float) + sizeof(uint32_t);
    return (sizeof(struct cml_saved_row) + media * of_medium + word - 1) / word;
}

size_t cml_saved_row_bytes(size_t media)
{
    return words_of(media) * sizeof(uint64_t);
}

/* Returns the number of rows to make room for. There is room for more rows than the limit, so that surplus
 * rows are sorted out a quarter of the limit at a time. */
static size_t capacity_of(const struct cml_saved_kind *kind)
{
    return kind->limit + kind->limit / 4 + 1024;
}

double cml_saved_bytes(const struct cml_saved_kind *kind)
{
    return kind->limit
               ? (double)capacity_of(kind) * (double)(cml_saved_row_bytes(kind->media) + sizeof(struct key))
               : 0;
}

cml_status cml_saved_create(const struct cml_saved_kind *kind, struct cml_saved **saved,
                            struct cml_error *err)
{
    *saved = NULL;
    if (!kind->limit) return CML_OK;
    struct cml_saved *made = calloc(1, sizeof *made);
    if (!made) return cml_fail_memory(err, sizeof *made, "saved photons");
    *made = (struct cml_saved){.media = kind->media,
                               .words = words_of(kind->media),
                               .limit = kind->limit,
                               .capacity = capacity_of(kind),
                               .beams = kind->beams,
                               .last = UINT64_MAX};
    made->row = calloc(made->capacity + 1, made->words * sizeof *made->row);
    made->key = calloc(made->capacity, sizeof *made->key);
    if (!made->row || !made->key) {
        cml_saved_free(made);
        return cml_fail_memory(err, cml_saved_bytes(kind), "saved photons");
    }
    *saved = made;
    return CML_OK;
}

void cml_saved_free(struct cml_saved *saved)
{
    if (!saved) return;
    free(saved->row);
    free(saved->key);
    free(saved);
}

/* ---- order ---- */

/* Returns the packet index of row i, the first word of the row. */
static uint64_t index_at(const struct cml_saved *saved, size_t i)
{
    return saved->row[i * saved->words];
}

/* Returns a hash spread evenly over all 2^64 numbers, different for different indices: the finaliser of
 * splitmix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014; variant 13 of D. Stafford). */
static uint64_t mixed(uint64_t index)
{
    index = (index ^ index >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    index = (index ^ index >> 27) * UINT64_C(0x94d049bb133111eb);
    return index ^ index >> 31;
}

/* Returns the order in which packets are kept: by index for one beam, by hash for several. Indices of several
 * beams depend on the number of photons, so no order of the indices would be fair to all beams. */
static uint64_t order_of(const struct cml_saved *saved, uint64_t index)
{
    return saved->beams > 1 ? mixed(index) : index;
}

static void swap_keys(struct key *one, struct key *other)
{
    const struct key key = *one;
    *one = *other;
    *other = key;
}

/* Partitions the keys begin to end - 1 (Hoare): keys not above the pivot come to the front. Returns the start
 * of the others, which is behind the first key and not behind the last. */
static size_t part_keys(struct key *key, size_t begin, size_t end)
{
    const uint64_t pivot = key[begin + (end - begin - 1) / 2].order;
    for (size_t i = begin, j = end - 1;; i++, j--) {
        while (key[i].order < pivot) i++;
        while (pivot < key[j].order) j--;
        if (i >= j) return j + 1;
        swap_keys(&key[i], &key[j]);
    }
}

/* Sorts the first `most` keys of all (Quicksort that ignores ranges behind them). The shorter part goes to a
 * recursive call, so the recursion is shallow. */
static void sort_keys(struct key *key, size_t begin, size_t end, size_t most)
{
    while (end - begin > 1 && begin < most) {
        const size_t middle = part_keys(key, begin, end);
        const bool first_is_short = middle - begin < end - middle;
        sort_keys(key, first_is_short ? begin : middle, first_is_short ? middle : end, most);
        if (first_is_short)
            begin = middle;
        else
            end = middle;
    }
}

/* Moves row key[i].at to place i for all i, one cycle of places after another. */
static void move_rows(struct cml_saved *saved)
{
    const size_t size = saved->words * sizeof *saved->row;
    uint64_t *const spare = saved->row + saved->capacity * saved->words;
    for (size_t begin = 0; begin < saved->count; begin++) {
        size_t to = begin;
        if (saved->key[begin].at == begin) continue;
        memcpy(spare, saved->row + begin * saved->words, size);
        for (size_t from; (from = saved->key[to].at) != begin; to = from) {
            memcpy(saved->row + to * saved->words, saved->row + from * saved->words, size);
            saved->key[to].at = to;
        }
        memcpy(saved->row + to * saved->words, spare, size);
        saved->key[to].at = to;
    }
}

/* Makes the keys of all rows. Returns true if the rows are in order already. */
static bool make_keys(struct cml_saved *saved, bool by_index)
{
    bool sorted = true;
    for (size_t i = 0; i < saved->count; i++) {
        const uint64_t index = index_at(saved, i);
        saved->key[i] = (struct key){by_index ? index : order_of(saved, index), i};
        sorted = sorted && (i == 0 || saved->key[i].order >= saved->key[i - 1].order);
    }
    return sorted;
}

/* Sorts the rows by index, or in the order in which packets are kept. If there are more rows than the
 * limit, only the first `limit` are in order. */
static void arrange(struct cml_saved *saved, bool by_index)
{
    if (make_keys(saved, by_index)) return;
    sort_keys(saved->key, 0, saved->count, saved->limit);
    move_rows(saved);
}

/* If more were found than may stay, the packets with the lowest order numbers stay, and `last` becomes the
 * highest of these. */
struct cml_saved_sums cml_saved_sort(struct cml_saved *saved)
{
    if (saved->count >= saved->limit) {
        arrange(saved, false);
        saved->count = saved->limit;
        saved->last = order_of(saved, index_at(saved, saved->limit - 1));
    }
    arrange(saved, true);
    return (struct cml_saved_sums){saved->found, saved->count};
}

/* ---- adding ---- */

/* Packets behind the last one that can stay are counted, not kept. */
void cml_saved_add(struct cml_saved *saved, const void *rows, size_t count)
{
    const uint64_t *from = rows;
    saved->found += count;
    for (size_t i = 0; i < count; i++, from += saved->words) {
        if (order_of(saved, *from) > saved->last) continue;
        if (saved->count == saved->capacity) cml_saved_sort(saved);
        memcpy(saved->row + saved->count++ * saved->words, from, saved->words * sizeof *from);
    }
}

/* The upper bits of an index name the beam. */
bool cml_saved_may_have(const struct cml_saved *saved, uint64_t index, uint64_t photons)
{
    const uint64_t beam = index >> CML_SOURCE_SHIFT;
    return beam < saved->beams && index - (beam << CML_SOURCE_SHIFT) < photons;
}

const struct cml_saved_row *cml_saved_row(const struct cml_saved *saved, size_t i)
{
    return (const struct cml_saved_row *)(saved->row + i * saved->words);
}

size_t cml_saved_media(const struct cml_saved *saved)
{
    return saved->media;
}

/* If packets were dropped, the photons are covered whose order number is at most that of the last kept
 * packet. */
uint64_t cml_saved_covers(const struct cml_saved *saved, const struct cml_deal *run)
{
    struct cml_piece piece;
    uint64_t covers = 0;
    if (saved->found == saved->count) return run->end;
    if (saved->beams < 2) return saved->last + 1;
    for (uint64_t turn = 0; turn < run->end; turn += piece.count) {
        piece = cml_deal_piece_at(run, turn);
        for (uint64_t i = 0; i < piece.count; i++)
            covers += mixed(piece.first + CML_NUM_BATCHES * i) <= saved->last;
    }
    return covers;
}

void cml_saved_clear(struct cml_saved *saved)
{
    saved->count = 0;
    saved->found = 0;
    saved->last = UINT64_MAX;
}

void cml_saved_add_found(struct cml_saved *saved, uint64_t more)
{
    saved->found += more;
}

/* ---- a thread's ---- */

cml_status cml_saved_part_create(const struct cml_saved_kind *kind, struct cml_saved_part **part,
                                 struct cml_error *err)
{
    *part = NULL;
    if (!kind->limit) return CML_OK;
    const size_t words = words_of(kind->media), capacity = words < PART_WORDS ? PART_WORDS / words : 1;
    const size_t size = sizeof **part + capacity * words * sizeof(uint64_t);
    *part = calloc(1, size);
    if (!*part) return cml_fail_memory(err, (double)size, "saved photons");
    (*part)->detected = kind->detected;
    (*part)->media = kind->media;
    (*part)->words = words;
    (*part)->capacity = capacity;
    return CML_OK;
}

void cml_saved_hand_in(struct cml_saved_part *part)
{
    if (!part) return;
    if (part->to.take) part->to.take(part->to.context, part->row, part->count);
    part->count = 0;
}

struct cml_saved_row *cml_saved_next(struct cml_saved_part *part)
{
    if (part->count == part->capacity) cml_saved_hand_in(part);
    return (struct cml_saved_row *)(part->row + part->count++ * part->words);
}
