/* A finished packet's entry into a tally, in the precision of the file that includes this.
 * SPDX-License-Identifier: MIT */
#ifndef CML_TALLY_PACKET_H
#define CML_TALLY_PACKET_H

#include "tally.h"
#include "walk.h"

/* What every finished packet has. */
struct cml_end {
    uint64_t index, absorbed;
    int fate, cause;
    cml_u32 w, interactions, boundary_events;
    real exit_x, exit_y, uz;
};

static inline void cml_tally_exit(const struct cml_setup *setup, const struct cml_end *end,
                                  struct cml_tally *tally)
{
    uint64_t *cells = end->fate == CML_FATE_REFLECTED ? tally->Rd_ra : tally->Tt_ra;
    int overflow;
    const int ir = cml_radial_bin(setup, end->exit_x, end->exit_y, &overflow);
    const int ia = cml_angle_bin(setup, end->uz);
    cells[(size_t)ir * (size_t)setup->na + (size_t)ia] += end->w;
    if (overflow) tally->book[CML_BOOK_OVERFLOW_R] += end->w;
}

static inline void cml_tally_square(uint64_t total, cml_u128 *square)
{
    *square += (cml_u128)total * total;
}

/* The packet's totals, squared. */
static inline void cml_tally_squares(const struct cml_setup *setup, const struct cml_end *end,
                                     struct cml_tally *tally)
{
    const uint64_t specular = setup->specular + (uint64_t)(end->fate == CML_FATE_SPECULAR ? end->w : 0);
    cml_tally_square(end->absorbed, &tally->square[CML_TOTAL_ABSORBED]);
    if (specular) cml_tally_square(specular, &tally->square[CML_TOTAL_SPECULAR]);
    if (end->fate == CML_FATE_REFLECTED) cml_tally_square(end->w, &tally->square[CML_TOTAL_REFLECTED]);
    if (end->fate == CML_FATE_TRANSMITTED) cml_tally_square(end->w, &tally->square[CML_TOTAL_TRANSMITTED]);
}

static inline void cml_tally_loss(const struct cml_end *end, struct cml_tally *tally)
{
    if (end->fate == CML_FATE_TRAPPED) tally->count[CML_COUNT_TRAPPED]++;
    if (end->fate != CML_FATE_LOST) return;
    tally->count[CML_COUNT_LOST_NO_SURFACE + end->cause - CML_LOST_NO_SURFACE]++;
    cml_lost_list_add(&tally->lost, end->index);
}

/* Books, counts, squares and exit bin. */
static inline void cml_tally_end(const struct cml_setup *setup, const struct cml_end *end,
                                 struct cml_tally *tally)
{
    static const enum cml_book book_of[CML_NUM_FATES] = {
        [CML_FATE_ABSORBED] = CML_BOOK_ROULETTE,       [CML_FATE_REFLECTED] = CML_BOOK_REFLECTED,
        [CML_FATE_TRANSMITTED] = CML_BOOK_TRANSMITTED, [CML_FATE_SPECULAR] = CML_BOOK_SPECULAR,
        [CML_FATE_TRAPPED] = CML_BOOK_TRAPPED,         [CML_FATE_LOST] = CML_BOOK_LOST,
    };
    if (end->fate == CML_FATE_REFLECTED || end->fate == CML_FATE_TRANSMITTED)
        cml_tally_exit(setup, end, tally);
    else
        cml_tally_loss(end, tally);
    cml_tally_squares(setup, end, tally);
    tally->book[book_of[end->fate]] += end->w;
    tally->book[CML_BOOK_LAUNCHED] += CML_WEIGHT_ONE;
    tally->book[CML_BOOK_SPECULAR] += setup->specular;
    tally->book[CML_BOOK_ABSORBED] += end->absorbed;
    tally->count[CML_COUNT_PHOTONS]++;
    tally->count[CML_COUNT_INTERACTIONS] += end->interactions;
    tally->count[CML_COUNT_BOUNDARY_EVENTS] += end->boundary_events;
}

/* What only a packet of kernels/walk.h keeps for itself. */
static inline void cml_tally_events(const struct cml_packet *packet, struct cml_tally *tally)
{
    tally->book[CML_BOOK_GAINED] += packet->gained;
    tally->book[CML_BOOK_ROULETTE] += packet->roulette;
    tally->book[CML_BOOK_OVERFLOW_R] += packet->overflow_r;
    tally->book[CML_BOOK_OVERFLOW_Z] += packet->overflow_z;
    tally->book[CML_BOOK_ABOVE] += packet->above;
    tally->count[CML_COUNT_QUERIES] += packet->queries;
    tally->count[CML_COUNT_SHADING_OVERRULED] += packet->shading_overruled;
}

static inline struct cml_end cml_end_of(const struct cml_packet *packet)
{
    const struct cml_end end = {
        .index = packet->index,
        .absorbed = packet->absorbed,
        .fate = packet->fate,
        .cause = packet->cause,
        .w = packet->w,
        .interactions = packet->interactions,
        .boundary_events = packet->boundary_events,
        .exit_x = packet->exit_x,
        .exit_y = packet->exit_y,
        .uz = packet->u.z,
    };
    return end;
}

static inline void cml_tally_packet(const struct cml_setup *setup, const struct cml_packet *packet,
                                    struct cml_tally *tally)
{
    const struct cml_end end = cml_end_of(packet);
    cml_tally_events(packet, tally);
    cml_tally_end(setup, &end, tally);
}

#endif
