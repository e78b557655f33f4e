/* What must hold for every packet, for CML_ASSERT: nothing calls these in release builds and on devices.
 * SPDX-License-Identifier: MIT */
#ifndef CML_INVARIANTS_H
#define CML_INVARIANTS_H

#include "optics.h"
#include "surface_hit.h"
#include "types.h"

/* | |u|^2 - 1 | within what one event leaves of it by rounding. unit.optics finds at most 1e-6, 9
 * spacings of single precision, over a million events. What is not a number passes: P9 ends such packets. */
CML_FN int cml_is_unit(struct cml_vec u)
{
    return !(CML_FABS(cml_dot(u, u) - 1) > 16 * CML_EPSILON);
}

/* Whether p, in the frame of a boundary, lies on its side (+1 below it, -1 above), as far as
 * bounds of depth can tell: those of the pyramid's cell that p is in (clearance.h). err: what rounding may
 * take from its depth, cm; from a curved boundary it may take as much as cml_leaked allows. */
CML_FN int cml_is_on_side(const struct cml_world *world, int boundary, struct cml_vec p, real side, real err)
{
    const CML_GLOBAL struct cml_surface *surface = &world->surfaces[boundary];
    const CML_GLOBAL struct cml_clearance *grid = &surface->clearance;
    const CML_GLOBAL real *bounds = (side > 0 ? world->highest : world->deepest) + grid->first;
    if (cml_is_plane(world, boundary)) return !(side * p.z < -err);
    if (grid->size == 0) return 1;
    const real margin = (surface->highest - surface->lowest) * (real)0.0009765625 + err;
    const struct cml_vec q = cml_from_scene_axis(world, p);
    const struct cml_vec still = {0, 0, 0};
    if (grid->form == CML_CLEARANCE_PERIOD)
        return !(side * p.z < -cml_clearance_of_period(grid, bounds - grid->first, q, still, -side) - margin);
    int cell = cml_clearance_index(grid, CML_SQRT(q.x * q.x + q.y * q.y), 0);
    if (surface->kind != CML_SURFACE_CONE)
        cell = cml_clearance_index(grid, q.y, grid->corner_y) * grid->size +
               cml_clearance_index(grid, q.x, grid->corner_x);
    return !(side * p.z < side * bounds[cell] - margin);
}

/* Whether a packet that has come to p, in the frame of its medium, on a path of height `step`
 * is still in that medium. */
CML_FN int cml_is_in_layer(const struct cml_world *world, int medium, struct cml_vec p, real step)
{
    const real span = world->media[medium].span, err = cml_err_depth(p.z, step) + cml_err_depth(span, span);
    struct cml_vec below = p;
    if (medium > world->setup.num_layers + 1) return 1; /* cml_leaked has told */
    below.z -= span;
    return medium > 0 && medium <= world->setup.num_layers && cml_is_on_side(world, medium - 1, p, 1, err) &&
           cml_is_on_side(world, medium, below, -1, err);
}

/* P10 for one packet, whose weight at the start and later gains are all accounted for. */
CML_FN int cml_packet_balances(const struct cml_world *world, CML_PACKET const struct cml_packet *packet)
{
    return CML_WEIGHT_ONE + packet->gained ==
           world->setup.specular + packet->absorbed + packet->roulette + packet->w;
}

#endif
