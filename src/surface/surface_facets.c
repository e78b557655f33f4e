/* Number and areas of the facets of a represented boundary. SPDX-License-Identifier: MIT */
#include "surface/surface_facets.h"

#include "base/constants.h"

#include <math.h>

/* Returns the number of facets of a boundary. Cones have one facet per ring, and the last ring is the outer
 * plane. A mesh has one facet per triangle, and one more for the outer plane. */
size_t cml_surface_facets(const struct cml_surface_def *def, const struct cml_map_def *map)
{
    if (def->kind == CML_SURFACE_PLANE) return map->nx > 0 ? (size_t)map->nx * (size_t)map->ny + 1 : 0;
    return (size_t)def->primitives + (def->kind == CML_SURFACE_MESH ? 1 : 0);
}

/* Returns the area over which a score of a facet is averaged, cm2. Facets of a plane are the map's pixels,
 * those of a mesh its triangles, those of a radial heightfield its cone frusta. The last facet is all the
 * plane outside, of infinite area. */
double cml_surface_facet_area(const struct cml_surface_def *def, const struct cml_map_def *map, size_t facet)
{
    if (facet + 1 >= cml_surface_facets(def, map)) return INFINITY;
    if (def->kind == CML_SURFACE_PLANE) return map->dx * map->dy;
    if (def->kind == CML_SURFACE_MESH) return cml_mesh_surface_area(def->mesh, facet);
    const double *r = def->r + facet, *z = def->z + facet;
    return CML_PI * (r[0] + r[1]) * hypot(r[1] - r[0], z[1] - z[0]);
}
