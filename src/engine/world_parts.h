/* Functions that the files that make a world share: world.c, world_bodies.c, world_detectors.c and
 * world_sources.c. Nothing else includes this file.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/world.h"
#include "scene/contact.h"

/* Allocates and fills the bodies of a world, and their media and surfaces, which stand behind those of the
 * layers. Defined in world_bodies.c. */
CML_NODISCARD cml_status cml_copy_bodies(const struct cml_scene *scene, const struct cml_surface_set *set,
                                         struct cml_owned_world *to, struct cml_error *err);

/* Fills the detectors of a world, and the grids over them. windows: of the run, or NULL. Defined in
 * world_detectors.c. */
CML_NODISCARD cml_status cml_set_detectors(const struct cml_scene *scene,
                                           const struct cml_surface_set *surfaces,
                                           const struct cml_window_table *windows, struct cml_owned_world *to,
                                           struct cml_error *err);

/* Returns an area as the walk reads it, counted from the scene's origin. Defined in world_detectors.c. */
struct cml_area cml_area_of(const struct cml_outline *outline, const double origin[2]);

/* Makes a grid over outlines: *made, with its lists behind those in `lists`. number: [count] what lists name
 * the outlines, rising. Defined in world_detectors.c. */
CML_NODISCARD cml_status cml_add_level(const struct cml_outline *outline, const int *number, int count,
                                       const double origin[2], struct cml_cell_lists *lists,
                                       struct cml_detector_level *made, struct cml_error *err);

/* Fills the faces and ports of a world, before its sources. Defined in world_detectors.c. */
CML_NODISCARD cml_status cml_set_contacts(const struct cml_scene *scene, const double origin[2],
                                          struct cml_owned_world *to, struct cml_error *err);

/* Fills the sources of a world, after all its other parts. start_as: as in cml_engine_options. CML_E_INPUT: a
 * beam starts within rounding of a surface, or has a larger numerical aperture than the index of the medium
 * in which it starts. Defined in world_sources.c. */
CML_NODISCARD cml_status cml_set_sources(const struct cml_scene *scene,
                                         const struct cml_surface_set *surfaces,
                                         const struct cml_surface_set *start_as, struct cml_owned_world *to,
                                         struct cml_error *err);

/* Returns the share of beam k that faces and ports stop, by 4096 places of its lattice. *passes: 1 if a part
 * passes boundary 0, or meets it from below, or never. Defined in world_detectors.c. */
double cml_stopped_share(const struct cml_world *world, int k, int *passes);

/* Returns a vector rounded to `real`. */
static inline struct cml_vec cml_vec_of(double x, double y, double z)
{
    const struct cml_vec v = {(real)x, (real)y, (real)z};
    return v;
}

/* Returns an opaque surface on a medium of index n. It keeps the share 1 - R of a weight. For R = 0 it keeps
 * all of the weight, and for R = 1 nothing, both exact to the last bit. */
static inline struct cml_backing cml_backing_of(const struct cml_backing_def *def, int boundary, double n)
{
    return (struct cml_backing){.kind = (int)def->kind,
                                .boundary = def->kind == CML_BACKING_NONE ? -1 : boundary,
                                .kept = (real)(def->R > 0 ? 1 - def->R : 1 + 4 * (double)CML_EPSILON),
                                .n = (real)(def->n / n),
                                .k = (real)(def->k / n)};
}

/* Fills the optics of a medium. All quotients are taken in double and rounded once. absorb is a little over 1
 * in a medium that does not scatter (kernels/types.h). */
static inline void cml_copy_optics(const struct cml_medium_def *from, struct cml_medium *to)
{
    const double mut = cml_medium_mut(from);
    to->n = (real)from->n;
    to->mut = (real)mut;
    to->mfp = mut > 0 ? (real)(1 / mut) : CML_INFINITY;
    to->absorb = from->mus > 0 ? (real)(from->mua / mut) : (mut > 0 ? 1 + 4 * CML_EPSILON : (real)0);
    to->g = (real)from->g;
    if (from->phase) to->g = (real)((cml_phase_mean(from->phase) < 0 ? -1 : 1) * (2 + from->phase->index));
}
