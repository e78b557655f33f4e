/* Packets that have left, saved one by one (P18). Of all that come those with the smallest indices stay, or
 * of several beams those whose indices have the smallest hashes, as many as the limit allows: so which these
 * are depends on no order, and threads, ranks, restarts and longer runs agree. Threads
 * collect rows in a buffer of their own and hand them in when it is full. All memory is there before the
 * first packet flies. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "tally/deal.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A row. Behind it stand, each [media], the length of the packet's path in every medium, float in cm, the
 * number of its interactions there, uint32_t, and the sum of 1 - cosine of its scatterings there, float. */
struct cml_saved_row {
    uint64_t index;
    uint32_t weight, touches; /* 2^-31 of a packet; boundary events */
    float place[3];           /* of the scene, cm, where it touched a surface last */
    float direction[3];
    float optical, deepest; /* path times index; depth in the scene; cm, NaN where it has touched nothing */
    uint32_t detector;      /* number of the first that saw it, from 1; 0: none */
    uint32_t side;          /* enum cml_saved_side */
};

/* fresh: on top, without ever having been in the material (Rsp). */
enum cml_saved_side { CML_SAVED_TOP, CML_SAVED_BOTTOM, CML_SAVED_FRESH };

/* What is saved. Zeroed: nothing. */
struct cml_saved_kind {
    uint64_t limit; /* of rows */
    bool detected;  /* only what a detector has seen */
    size_t media;
    uint64_t beams;
};

struct cml_saved;

/* NULL where nothing is saved. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_saved_create(const struct cml_saved_kind *kind, struct cml_saved **saved,
                                          struct cml_error *err);
void cml_saved_free(struct cml_saved *saved);

/* Bytes of a row with what stands behind it; bytes that a cml_saved takes when it is full. */
size_t cml_saved_row_bytes(size_t media);
double cml_saved_bytes(const struct cml_saved_kind *kind);

/* Adds rows that lie one behind the other. */
void cml_saved_add(struct cml_saved *saved, const void *rows, size_t count);

/* How many packets have been added; how many of them stay. From here on rows lie in the order of their
 * indices, until others are added. */
struct cml_saved_sums {
    uint64_t found;
    size_t kept;
};
struct cml_saved_sums cml_saved_sort(struct cml_saved *saved);

/* Whether a run of so many photons can have one of this index. */
bool cml_saved_may_have(const struct cml_saved *saved, uint64_t index, uint64_t photons);

/* Row i of those that stay. */
const struct cml_saved_row *cml_saved_row(const struct cml_saved *saved, size_t i);
size_t cml_saved_media(const struct cml_saved *saved);

/* How many photons of a run, whose round from photon 0 on this is, none of which would have a row and has
 * not, after cml_saved_sort: its first ones, of several beams a sample of all, which are counted one by one.
 */
uint64_t cml_saved_covers(const struct cml_saved *saved, const struct cml_deal *run);

/* For those who move or store them, after cml_saved_sort: forgets all; says that `more` packets were found
 * whose rows are not kept, or are added by themselves. */
void cml_saved_clear(struct cml_saved *saved);
void cml_saved_find(struct cml_saved *saved, uint64_t more);

/* Takes what threads hand in, from any of them at any time. take NULL: nobody wants it. */
struct cml_saved_taker {
    void (*take)(void *context, const void *rows, size_t count);
    void *context;
};

/* What a thread collects; NULL where nothing is saved. */
struct cml_saved_part {
    struct cml_saved_taker to;
    bool detected;
    size_t media, words, count, capacity;
    uint64_t row[]; /* [capacity][words] */
};

CML_NODISCARD cml_status cml_saved_part_create(const struct cml_saved_kind *kind,
                                               struct cml_saved_part **part, struct cml_error *err);

/* A new row to be filled in. */
struct cml_saved_row *cml_saved_next(struct cml_saved_part *part);

/* Hands in what has been collected; part may be NULL. */
void cml_saved_hand_in(struct cml_saved_part *part);
