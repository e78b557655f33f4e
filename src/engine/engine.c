/* SPDX-License-Identifier: MIT */
#include "engine/engine.h"

#include "surface/surface_facets.h"
#include "types.h"

/* Facets are counted on the surfaces that are flown: a boundary that is tessellated has other ones than its
 * cones. */
struct cml_grid cml_engine_grid(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                const struct cml_engine_options *options)
{
    const struct cml_map_def *map = &scene->map;
    struct cml_grid grid = {.nr = scene->nr,
                            .nz = scene->nz,
                            .na = scene->na,
                            .num_layers = scene->num_layers,
                            .absorption = options->absorption,
                            .nx = map->nx,
                            .ny = map->ny,
                            .map_na = map->angles ? scene->na : 1,
                            .volume = map->volume && options->absorption};
    for (int b = 0; scene->facets && surfaces && b < surfaces->count; b++)
        grid.facets += cml_surface_facets(&surfaces->item[b], map);
    return grid;
}

const char *cml_fate_name(int fate)
{
    static const char *const names[CML_NUM_FATES] = {"alive",    "absorbed", "reflected", "transmitted",
                                                     "specular", "trapped",  "lost"};
    return names[fate];
}

const char *cml_lost_cause_name(int cause)
{
    static const char *const names[CML_NUM_LOST_CAUSES] = {"not lost", "no surface found", "not a number",
                                                           "stuck", "leaked through a boundary"};
    return names[cause];
}
