/* SPDX-License-Identifier: MIT */
#include "surface/surface_facets.h"

#include "base/constants.h"
#include "geometry/vec3.h"

#include <math.h>

/* The last ring of cones is the outer plane already. */
size_t cml_surface_facets(const struct cml_surface_def *def, const struct cml_map_def *map)
{
    if (def->kind == CML_SURFACE_PLANE) return map->nx > 0 ? (size_t)map->nx * (size_t)map->ny + 1 : 0;
    return (size_t)def->primitives + (def->kind == CML_SURFACE_MESH ? 1 : 0);
}

static double triangle_area(const struct cml_mesh_surface *surface, size_t facet)
{
    double middle[3];
    const struct cml_mesh *mesh = cml_mesh_surface_mesh(surface, middle);
    const uint32_t *corner = mesh->triangle[cml_mesh_surface_triangle(surface, facet)];
    double normal[3];
    cml_vec3_area(mesh->vertex[corner[0]], mesh->vertex[corner[1]], mesh->vertex[corner[2]], normal);
    return 0.5 * cml_vec3_length(normal);
}

double cml_surface_facet_area(const struct cml_surface_def *def, const struct cml_map_def *map, size_t facet)
{
    if (facet + 1 >= cml_surface_facets(def, map)) return INFINITY;
    if (def->kind == CML_SURFACE_PLANE) return map->dx * map->dy;
    if (def->kind == CML_SURFACE_MESH) return triangle_area(def->mesh, facet);
    const double *r = def->r + facet, *z = def->z + facet;
    return CML_PI * (r[0] + r[1]) * hypot(r[1] - r[0], z[1] - z[0]);
}
