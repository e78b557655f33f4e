/* Number and areas of the facets of a represented boundary. SPDX-License-Identifier: MIT */
#include "surface/surface_facets.h"

#include "base/constants.h"

#include <math.h>

size_t cml_surface_facets(const struct cml_surface_def *def, const struct cml_map_def *map)
{
    if (def->kind == CML_SURFACE_PLANE) return map->nx > 0 ? (size_t)map->nx * (size_t)map->ny + 1 : 0;
    return (size_t)def->primitives + (def->kind == CML_SURFACE_MESH ? 1 : 0);
}

double cml_surface_facet_area(const struct cml_surface_def *def, const struct cml_map_def *map, size_t facet)
{
    if (facet + 1 >= cml_surface_facets(def, map)) return INFINITY;
    if (def->kind == CML_SURFACE_PLANE) return map->dx * map->dy;
    if (def->kind == CML_SURFACE_MESH) return cml_mesh_surface_area(def->mesh, facet);
    const double *r = def->r + facet, *z = def->z + facet;
    return CML_PI * (r[0] + r[1]) * hypot(r[1] - r[0], z[1] - z[0]);
}
