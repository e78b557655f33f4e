/* Packets that have left, saved one by one (rule P18). The packets with the smallest indices stay, up to a
 * limit; with several beams those whose indices have the smallest hashes. So the choice depends on no order:
 * threads, ranks, restarts and longer runs agree. Threads collect rows in buffers of their own, and pass a
 * full buffer on to one receiver. All memory is allocated before the first packet flies.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "tally/deal.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A row: one saved packet. Behind it follow three arrays, each [media]: the packet's path length (float, cm),
 * its number of interactions (uint32_t), and its sum of 1 - cosine over scatterings (float). */
struct cml_saved_row {
    uint64_t index;
    uint32_t weight, touches; /* weight in units of 2^-31 of a packet; number of boundary events */
    float place[3];           /* last point on a surface, scene coordinates, cm */
    float direction[3];
    /* optical: path length times index, cm. deepest: largest depth in the scene, cm. NaN if the packet has
     * touched nothing. */
    float optical, deepest;
    uint32_t detector; /* number of the first detector that saw the packet, from 1; 0: none */
    uint32_t side;     /* enum cml_saved_side */
};

/* The side where a packet left. CML_SAVED_FRESH: on top, without having entered the material (Rsp). */
enum cml_saved_side { CML_SAVED_TOP, CML_SAVED_BOTTOM, CML_SAVED_FRESH };

/* A choice of packets to save. Zeroed: none. */
struct cml_saved_kind {
    uint64_t limit; /* largest number of rows */
    bool detected;  /* only packets that a detector has seen */
    size_t media;
    uint64_t beams;
};

struct cml_saved;

/* Makes room for saved packets; NULL if none are to be saved. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_saved_create(const struct cml_saved_kind *kind, struct cml_saved **saved,
                                          struct cml_error *err);
void cml_saved_free(struct cml_saved *saved);

/* Return the bytes of a row with the arrays behind it, and the bytes of a full cml_saved. */
size_t cml_saved_row_bytes(size_t media);
double cml_saved_bytes(const struct cml_saved_kind *kind);

/* Adds `count` rows that lie one behind the other. */
void cml_saved_add(struct cml_saved *saved, const void *rows, size_t count);

/* The numbers of packets found, and of packets whose rows are kept. cml_saved_sort drops surplus rows and
 * sorts the others by index; they stay in this order until rows are added. */
struct cml_saved_sums {
    uint64_t found;
    size_t kept;
};
struct cml_saved_sums cml_saved_sort(struct cml_saved *saved);

/* True if a run of so many photons can have a packet of this index. */
bool cml_saved_may_have(const struct cml_saved *saved, uint64_t index, uint64_t photons);

/* Returns row i of the rows that are kept. */
const struct cml_saved_row *cml_saved_row(const struct cml_saved *saved, size_t i);
size_t cml_saved_media(const struct cml_saved *saved);

/* Returns how many photons of a run, whose round begins at photon 0, the kept rows cover: each of these
 * photons has a row if it left. These are the first photons; with several beams a sample of all, counted one
 * by one. Call cml_saved_sort first. */
uint64_t cml_saved_covers(const struct cml_saved *saved, const struct cml_deal *run);

/* cml_saved_clear forgets all rows and counts. cml_saved_add_found adds `more` to the number of packets
 * found, whose rows are not kept or are added separately. Both are for code that moves or stores rows, after
 * cml_saved_sort. */
void cml_saved_clear(struct cml_saved *saved);
void cml_saved_add_found(struct cml_saved *saved, uint64_t more);

/* The receiver of saved rows. Threads call `take` at any time when their buffers are full. If take is
 * NULL, rows are dropped. */
struct cml_saved_taker {
    void (*take)(void *context, const void *rows, size_t count);
    void *context;
};

/* A thread's buffer of rows; NULL if no packets are saved. */
struct cml_saved_part {
    struct cml_saved_taker to;
    bool detected;
    size_t media, words, count, capacity;
    uint64_t row[]; /* [capacity][words] rows */
};

CML_NODISCARD cml_status cml_saved_part_create(const struct cml_saved_kind *kind,
                                               struct cml_saved_part **part, struct cml_error *err);

/* Returns a new row to be filled in. */
struct cml_saved_row *cml_saved_next(struct cml_saved_part *part);

/* Passes all collected rows to the receiver (`to`), and empties the buffer. part may be NULL. */
void cml_saved_hand_in(struct cml_saved_part *part);
