/* A finished packet's entry into a tally, in the precision of the file that includes this.
 * SPDX-License-Identifier: MIT */
#ifndef CML_TALLY_PACKET_H
#define CML_TALLY_PACKET_H

#include "tally.h"
#include "walk.h"

static inline void cml_tally_exit(const struct cml_setup *setup, const struct cml_packet *packet,
                                  struct cml_tally *tally)
{
    const bool up = packet->fate == CML_FATE_REFLECTED;
    uint64_t *cells = up ? tally->Rd_ra : tally->Tt_ra;
    int overflow;
    const int ir = cml_radial_bin(setup, packet->exit_x, packet->exit_y, &overflow);
    const int ia = cml_angle_bin(setup, packet->u.z);
    cells[(size_t)ir * (size_t)setup->na + (size_t)ia] += packet->w;
    if (overflow) tally->book[CML_BOOK_OVERFLOW_R] += packet->w;
}

/* The packet's totals, squared. */
static inline void cml_tally_squares(const struct cml_setup *setup, const struct cml_packet *packet,
                                     struct cml_tally *tally)
{
    uint64_t total[CML_NUM_TOTALS] = {setup->specular, 0, 0, packet->absorbed};
    if (packet->fate == CML_FATE_SPECULAR) total[CML_TOTAL_SPECULAR] += packet->w;
    if (packet->fate == CML_FATE_REFLECTED) total[CML_TOTAL_REFLECTED] = packet->w;
    if (packet->fate == CML_FATE_TRANSMITTED) total[CML_TOTAL_TRANSMITTED] = packet->w;
    for (int i = 0; i < CML_NUM_TOTALS; i++) tally->square[i] += (cml_u128)total[i] * total[i];
}

/* Books, counts, squares and exit bin. */
static inline void cml_tally_packet(const struct cml_setup *setup, const struct cml_packet *packet,
                                    struct cml_tally *tally)
{
    static const enum cml_book book_of[CML_NUM_FATES] = {
        [CML_FATE_ABSORBED] = CML_BOOK_ROULETTE,       [CML_FATE_REFLECTED] = CML_BOOK_REFLECTED,
        [CML_FATE_TRANSMITTED] = CML_BOOK_TRANSMITTED, [CML_FATE_SPECULAR] = CML_BOOK_SPECULAR,
        [CML_FATE_TRAPPED] = CML_BOOK_TRAPPED,         [CML_FATE_LOST] = CML_BOOK_LOST,
    };
    const int fate = packet->fate;
    if (fate == CML_FATE_REFLECTED || fate == CML_FATE_TRANSMITTED) cml_tally_exit(setup, packet, tally);
    cml_tally_squares(setup, packet, tally);
    tally->book[book_of[fate]] += packet->w;
    tally->book[CML_BOOK_LAUNCHED] += CML_WEIGHT_ONE;
    tally->book[CML_BOOK_SPECULAR] += setup->specular;
    tally->book[CML_BOOK_GAINED] += packet->gained;
    tally->book[CML_BOOK_ROULETTE] += packet->roulette;
    tally->book[CML_BOOK_ABSORBED] += packet->absorbed;
    tally->book[CML_BOOK_OVERFLOW_R] += packet->overflow_r;
    tally->book[CML_BOOK_OVERFLOW_Z] += packet->overflow_z;
    tally->book[CML_BOOK_ABOVE] += packet->above;
    tally->count[CML_COUNT_PHOTONS]++;
    tally->count[CML_COUNT_INTERACTIONS] += packet->interactions;
    tally->count[CML_COUNT_BOUNDARY_EVENTS] += packet->boundary_events;
    tally->count[CML_COUNT_QUERIES] += packet->queries;
    tally->count[CML_COUNT_SHADING_OVERRULED] += packet->shading_overruled;
    tally->count[CML_COUNT_TRAPPED] += fate == CML_FATE_TRAPPED;
    if (fate != CML_FATE_LOST) return;
    tally->count[CML_COUNT_LOST_NO_SURFACE + packet->cause - CML_LOST_NO_SURFACE]++;
    cml_lost_list_add(&tally->lost, packet->index);
}

#endif
