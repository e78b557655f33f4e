/* A finished packet's entry into the tallies of an OpenCL device: weight balance, counts and exit
 * bins, which src/engine/terminated_packets_inl.h adds up on the host, for many packets at once. OpenCL C
 * only. SPDX-License-Identifier: MIT */
#ifndef CML_DEVICE_SCORE_H
#define CML_DEVICE_SCORE_H

#include "walk.h"

CML_FN enum cml_balance_term cml_balance_term_of(int fate)
{
    return fate == CML_FATE_ABSORBED      ? CML_BALANCE_ROULETTE
           : fate == CML_FATE_REFLECTED   ? CML_BALANCE_REFLECTED
           : fate == CML_FATE_TRANSMITTED ? CML_BALANCE_TRANSMITTED
           : fate == CML_FATE_SPECULAR    ? CML_BALANCE_SPECULAR
           : fate == CML_FATE_TRAPPED     ? CML_BALANCE_TRAPPED
                                          : CML_BALANCE_LOST;
}

/* R and T by exit bin; what is rare by its cause. */
CML_FN void cml_score_fate(const struct cml_setup *setup, const struct cml_packet *packet,
                           const struct cml_deposits *to)
{
    if (packet->fate == CML_FATE_REFLECTED || packet->fate == CML_FATE_TRANSMITTED) {
        const int ir = cml_radial_bin(setup, packet->exit_x, packet->exit_y);
        const int cell = ir * setup->na + cml_angle_bin(setup, packet->u.z);
        cml_add_exit(to, packet->fate == CML_FATE_REFLECTED, cell, packet->w);
    } else if (packet->fate == CML_FATE_TRAPPED) {
        cml_add_count(to, CML_COUNT_TRAPPED, 1);
    } else if (packet->fate == CML_FATE_LOST) {
        const int first = (int)CML_COUNT_LOST_NO_SURFACE - (int)CML_LOST_NO_SURFACE;
        cml_add_count(to, (enum cml_count)(first + packet->cause), 1);
        cml_add_lost(to, packet->index);
    }
}

CML_FN void cml_score(const struct cml_setup *setup, const struct cml_packet *packet,
                      const struct cml_deposits *to)
{
    cml_score_fate(setup, packet, to);
    cml_add_to_balance(to, cml_balance_term_of(packet->fate), packet->w);
    cml_add_to_balance(to, CML_BALANCE_LAUNCHED, CML_WEIGHT_ONE);
    cml_add_to_balance(to, CML_BALANCE_SPECULAR, setup->specular);
    cml_add_to_balance(to, CML_BALANCE_ABSORBED, packet->absorbed);
    cml_add_to_balance(to, CML_BALANCE_GAINED, packet->gained);
    cml_add_to_balance(to, CML_BALANCE_ROULETTE, packet->roulette);
    cml_add_count(to, CML_COUNT_PHOTONS, 1);
    cml_add_count(to, CML_COUNT_INTERACTIONS, packet->interactions);
    cml_add_count(to, CML_COUNT_BOUNDARY_EVENTS, packet->boundary_events);
    cml_add_count(to, CML_COUNT_QUERIES, packet->queries);
    cml_add_count(to, CML_COUNT_SHADING_OVERRULED, packet->shading_overruled);
}

#endif
