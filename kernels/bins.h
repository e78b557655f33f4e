/* Bins of radius, depth, pixel and angle (P7), gates of time (P11), and the bins into which a finished packet
 * has left.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "mathf.h"
#include "types.h"

/* Returns the radial bin of a position (P7), 0 to nr - 1, or nr beyond the last bin. */
CML_FN int cml_radial_bin(const struct cml_setup *setup, real x, real y)
{
    const real sx = x + setup->r0_x, sy = y + setup->r0_y, last = (real)setup->nr;
    const real bin = CML_SQRT(CML_FMA(sx, sx, sy * sy)) * setup->per_dr;
    return (int)(bin < last ? bin : last);
}

/* Returns the depth bin (P7), counted from 1; 0 above the scene's z = 0, nz + 1 below the last bin. z: depth
 * in the frame of the medium, cm; bins: depth of this frame in bins of dz (struct cml_medium). */
CML_FN int cml_depth_bin(const struct cml_setup *setup, real z, real bins)
{
    const real bin = CML_FMA(z, setup->per_dz, bins), last = (real)setup->nz;
    const real below = bin >= 0 ? bin : (real)-1;
    return (int)(below < last ? below : last) + 1;
}

/* True if a coordinate in units of bins lies in [0, n). False if it is NaN. */
CML_FN int cml_in_bins(real bin, int n)
{
    return (bin >= 0) & (bin < (real)n);
}

/* Returns the pixel of the map at x, y; nx * ny outside of the map. */
CML_FN cml_u64 cml_map_pixel(const struct cml_setup *setup, real x, real y)
{
    const struct cml_map *map = &setup->map;
    const real ix = CML_FMA(x + setup->x0, map->per_dx, map->half_x),
               iy = CML_FMA(y + setup->y0, map->per_dy, map->half_y);
    const cml_u64 pixels = (cml_u64)map->nx * (cml_u64)map->ny;
    const int inside = cml_in_bins(ix, map->nx) & cml_in_bins(iy, map->ny);
    return inside ? (cml_u64)iy * (cml_u64)map->nx + (cml_u64)ix : pixels;
}

/* Returns the voxel of the volume at p; nx * ny * nz outside of the volume. bins: depth of the medium's frame
 * in bins of dz. */
CML_FN cml_u64 cml_voxel(const struct cml_setup *setup, struct cml_vec p, real bins)
{
    const struct cml_map *map = &setup->map;
    const cml_u64 pixels = (cml_u64)map->nx * (cml_u64)map->ny, pixel = cml_map_pixel(setup, p.x, p.y);
    const real iz = CML_FMA(p.z, setup->per_dz, bins) - map->top_bins;
    const int inside = (pixel < pixels) & cml_in_bins(iz, setup->nz);
    return inside ? (cml_u64)iz * pixels + pixel : pixels * (cml_u64)setup->nz;
}

/* Returns the bin of the angle between a packet's direction and the outward vertical, 0..pi/2 (P7). uz: z of
 * the unit direction. */
CML_FN int cml_angle_bin(const struct cml_setup *setup, real uz)
{
    const real size = CML_FABS(uz), bin = cml_acos(size < 1 ? size : (real)1) * setup->per_da;
    const int ia = (int)bin;
    return ia < setup->na ? ia : setup->na - 1;
}

/* Returns the gate of an optical path (P11), 0 to count - 1, or count if the path is later than the last
 * gate. A path below 0 or NaN gives a gate too, because vector loops call this for lanes that score
 * nothing. */
CML_FN int cml_gate(struct cml_gates gates, real path)
{
    const real bin = path * gates.per_cm, last = (real)gates.count, at = bin < last ? bin : last;
    return (int)(at > 0 ? at : (real)0);
}

/* Returns the fate of a packet that has left for good (P6). entered: it has been in the material; above: it
 * left upwards. */
CML_FN int cml_fate_outside(int entered, int above)
{
    const int fate = above ? CML_FATE_REFLECTED : CML_FATE_TRANSMITTED;
    return entered ? fate : CML_FATE_SPECULAR;
}

/* The side to which a finished packet has left, and its bins there. A packet that has not left has no
 * side. */
struct cml_exit {
    /* At most one of these is 1: up for reflected, down for transmitted, fresh for light that came back up
     * without having entered. */
    int up, down, fresh;
    int r, alpha; /* bins of radius and angle (P7), filled for any fate */
    int gate;     /* gate of time (P11) */
};

/* Returns the side and bins of a packet at its end. fate: enum cml_fate; path: optical path, cm. The function
 * is inlined, so a caller pays only for the members that it reads. */
CML_FN struct cml_exit cml_exit_of(const struct cml_setup *setup, int fate, real x, real y, real uz,
                                   real path)
{
    const struct cml_exit exit = {fate == CML_FATE_REFLECTED, fate == CML_FATE_TRANSMITTED,
                                  fate == CML_FATE_SPECULAR,  cml_radial_bin(setup, x, y),
                                  cml_angle_bin(setup, uz),   cml_gate(setup->gates, path)};
    return exit;
}

/* True if the packet has left for good, on either side. */
CML_FN int cml_has_left(const struct cml_exit *exit)
{
    return exit->up | exit->down | exit->fresh;
}
