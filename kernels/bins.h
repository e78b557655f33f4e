/* Bins of positions and directions (P7): of radius, depth, pixel and angle.
 * SPDX-License-Identifier: MIT */
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
