/* Detectors: which of them see a packet that has left for good (P13). For the host only.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "optics.h"
#include "types.h"

/* Light that leaves along a straight line through p in direction u. p: in cm from the scene's origin, in the
 * frame of the outer medium. */
struct cml_ray_out {
    struct cml_vec p, u;
    int below; /* 1: the light leaves on the bottom side */
    int fresh; /* 1: the light has never been in the material */
    int port;  /* number of the port through which the light has left; 0: none */
    double n;  /* index of this port */
};

/* Finds *x, *y where the whole line crosses the level z. Returns 0 if the line is level. */
CML_FN int cml_crosses_level(const struct cml_ray_out *ray, real z, real *x, real *y)
{
    const real t = (z - ray->p.z) / ray->u.z;
    if (ray->u.z == 0) return 0;
    *x = CML_FMA(t, ray->u.x, ray->p.x);
    *y = CML_FMA(t, ray->u.y, ray->p.y);
    return 1;
}

/* Returns the square of the sine of the widest angle of a numerical aperture in a medium of index n; above 1:
 * the half space. */
CML_FN real cml_most_sine2(double na, double n)
{
    return (real)(na < n ? (na / n) * (na / n) : 2);
}

/* True if the light lies in the detector's cone. The comparison uses sines, because cosines do not resolve
 * small angles. */
CML_FN int cml_is_in_cone(const struct cml_detector *detector, const struct cml_ray_out *ray)
{
    const struct cml_vec u = ray->u;
    const real most = ray->port ? cml_most_sine2(detector->na, ray->n) : detector->most_sine2;
    const struct cml_vec a = detector->axis;
    const struct cml_vec cross = {CML_FMA(u.y, a.z, -(u.z * a.y)), CML_FMA(u.z, a.x, -(u.x * a.z)),
                                  CML_FMA(u.x, a.y, -(u.y * a.x))};
    return cml_dot(u, a) > 0 && cml_dot(cross, cross) <= most;
}

/* True if x, y (cm from the scene's origin) lie in an area. A border belongs to the area on its upper side,
 * so areas side by side hold everything, and nothing twice. Disks and rings do not hold their outer rim. */
CML_FN int cml_is_in_area(const struct cml_area *area, real x, real y)
{
    const real dx = x - area->middle.x, dy = y - area->middle.y;
    if (area->shape == CML_DETECTOR_RING) {
        const real square = CML_FMA(dx, dx, dy * dy);
        return (square >= area->inner2) & (square < area->outer2);
    }
    return (x >= area->low_x) & (x < area->high_x) & (y >= area->low_y) & (y < area->high_y);
}

/* True if light at x, y of the detector's level lies in its shape; *pixel is then the pixel of a map. A port
 * holds what has left through it. */
CML_FN int cml_is_in_shape(const struct cml_detector *detector, int port, real x, real y, cml_u64 *pixel)
{
    const struct cml_map *map = &detector->pixels;
    const real dx = x - detector->area.middle.x, dy = y - detector->area.middle.y;
    *pixel = 0;
    if (detector->shape == CML_DETECTOR_PORT) return port == detector->port;
    if (detector->shape != CML_DETECTOR_MAP) return cml_is_in_area(&detector->area, x, y);
    const real ix = CML_FMA(dx, map->per_dx, map->half_x), iy = CML_FMA(dy, map->per_dy, map->half_y);
    if (!((ix >= 0) & (ix < (real)map->nx) & (iy >= 0) & (iy < (real)map->ny))) return 0;
    *pixel = (cml_u64)iy * (cml_u64)map->nx + (cml_u64)ix;
    return 1;
}

/* Returns the share of a circle of radius r that lies in a disk. away: distance between both middles. All
 * lengths in cm. */
CML_FN real cml_share_in_disk(real r, real away, real radius)
{
    /* Square of the sine of half the angle. */
    const real square = (radius - (r - away)) * (radius + (r - away)) / (4 * r * away);
    const real per_turn = (real)0.3183098861837907;
    if (!(square > 0)) return 0;
    if (square >= 1) return 1;
    return square < (real)0.5 ? per_turn * cml_acos(1 - 2 * square) : 1 - per_turn * cml_acos(2 * square - 1);
}

/* Returns the share of a circle of radius r about the beam that lies in the ring of `arc`. */
CML_FN real cml_arc_share(struct cml_arc arc, real r)
{
    return cml_share_in_disk(r, arc.away, arc.outer) - cml_share_in_disk(r, arc.away, arc.inner);
}

/* True if the detector sees the ray. x, y: where the ray crosses the detector's level, from the scene's
 * origin. */
CML_FN int cml_detects(const struct cml_detector *detector, const struct cml_ray_out *ray, real x, real y,
                       cml_u64 *pixel)
{
    if (detector->diffuse && ray->fresh) return 0;
    return cml_is_in_shape(detector, ray->port, x, y, pixel) &&
           (!detector->aimed || cml_is_in_cone(detector, ray));
}

/* Returns the cell of the grid over a level's detectors that holds x, y; -1 if there are no detectors. */
CML_FN int cml_detector_cell(const struct cml_detector_level *level, real x, real y)
{
    const real ix = (x - level->corner_x) * level->per_cell_x, iy = (y - level->corner_y) * level->per_cell_y;
    const int inside = (ix >= 0) & (ix < (real)level->nx) & (iy >= 0) & (iy < (real)level->ny);
    return inside ? (int)iy * level->nx + (int)ix : -1;
}
