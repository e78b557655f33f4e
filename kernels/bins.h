/* Bins of positions and directions (P7): of radius, depth, pixel and angle; of times (P11); and the bins into
 * which a finished packet has left. SPDX-License-Identifier: MIT */
#pragma once

#include "mathf.h"
#include "types.h"

/* P7: radial bin of a position; nr beyond the last one. */
CML_FN int cml_radial_bin(const struct cml_setup *setup, real x, real y)
{
    const real sx = x + setup->r0_x, sy = y + setup->r0_y, last = (real)setup->nr;
    const real bin = CML_SQRT(CML_FMA(sx, sx, sy * sy)) * setup->per_dr;
    return (int)(bin < last ? bin : last);
}

/* P7: depth bin counted from 1; 0 above the scene's z = 0, nz + 1 below the last one. bins: of the medium. */
CML_FN int cml_depth_bin(const struct cml_setup *setup, real z, real bins)
{
    const real bin = CML_FMA(z, setup->per_dz, bins), last = (real)setup->nz;
    const real below = bin >= 0 ? bin : (real)-1;
    return (int)(below < last ? below : last) + 1;
}

/* Whether a coordinate in units of bins lies in 0..n, NaN not. */
CML_FN int cml_in_bins(real bin, int n)
{
    return (bin >= 0) & (bin < (real)n);
}

/* Pixel of the map; nx * ny outside of it. */
CML_FN cml_u64 cml_map_pixel(const struct cml_setup *setup, real x, real y)
{
    const struct cml_map *map = &setup->map;
    const real ix = CML_FMA(x + setup->x0, map->per_dx, map->half_x),
               iy = CML_FMA(y + setup->y0, map->per_dy, map->half_y);
    const cml_u64 pixels = (cml_u64)map->nx * (cml_u64)map->ny;
    const int inside = cml_in_bins(ix, map->nx) & cml_in_bins(iy, map->ny);
    return inside ? (cml_u64)iy * (cml_u64)map->nx + (cml_u64)ix : pixels;
}

/* Voxel of the volume; nx * ny * nz outside of it. bins: of the medium. */
CML_FN cml_u64 cml_voxel(const struct cml_setup *setup, struct cml_vec p, real bins)
{
    const struct cml_map *map = &setup->map;
    const cml_u64 pixels = (cml_u64)map->nx * (cml_u64)map->ny, pixel = cml_map_pixel(setup, p.x, p.y);
    const real iz = CML_FMA(p.z, setup->per_dz, bins) - map->top_bins;
    const int inside = (pixel < pixels) & cml_in_bins(iz, setup->nz);
    return inside ? (cml_u64)iz * pixels + pixel : pixels * (cml_u64)setup->nz;
}

/* P7: bin of the angle between the packet's direction and the outward vertical, 0..pi/2. */
CML_FN int cml_angle_bin(const struct cml_setup *setup, real uz)
{
    const real size = CML_FABS(uz), bin = cml_acos(size < 1 ? size : (real)1) * setup->per_da;
    const int ia = (int)bin;
    return ia < setup->na ? ia : setup->na - 1;
}

/* P11: gate of a path, the one for all that is later behind the last. What is not scored may have any path.
 */
CML_FN int cml_gate(struct cml_gates gates, real path)
{
    const real bin = path * gates.per_cm, last = (real)gates.count, at = bin < last ? bin : last;
    return (int)(at > 0 ? at : (real)0);
}

/* P6: the end of a packet that has left for good; entered: it has been in the material. */
CML_FN int cml_fate_outside(int entered, int above)
{
    const int fate = above ? CML_FATE_REFLECTED : CML_FATE_TRANSMITTED;
    return entered ? fate : CML_FATE_SPECULAR;
}

/* The side to which a finished packet has left, and its bins there. A packet that has not left has no side.
 */
struct cml_exit {
    int up, down,
        fresh;    /* 1 on one side at most: reflected, transmitted, or back up without having entered */
    int r, alpha; /* bins of radius and angle (P7), whatever the side */
    int gate;     /* P11 */
};

/* fate: enum cml_fate; x, y, uz, path: of a packet at its end. Inlined, each member costs only where it is
 * used. */
CML_FN struct cml_exit cml_exit_of(const struct cml_setup *setup, int fate, real x, real y, real uz,
                                   real path)
{
    const struct cml_exit exit = {fate == CML_FATE_REFLECTED, fate == CML_FATE_TRANSMITTED,
                                  fate == CML_FATE_SPECULAR,  cml_radial_bin(setup, x, y),
                                  cml_angle_bin(setup, uz),   cml_gate(setup->gates, path)};
    return exit;
}

CML_FN int cml_has_left(const struct cml_exit *exit)
{
    return exit->up | exit->down | exit->fresh;
}
