/* Functions that the files that make a world share: world.c, world_bodies.c, world_detectors.c and
 * world_sources.c. Nothing else includes this file.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/world.h"

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

/* Fills the sources of a world, after all its other parts. start_as: as in cml_engine_options. CML_E_INPUT: a
 * beam starts within rounding of a surface, or has a larger numerical aperture than the index of the medium
 * in which it starts. Defined in world_sources.c. */
CML_NODISCARD cml_status cml_set_sources(const struct cml_scene *scene,
                                         const struct cml_surface_set *surfaces,
                                         const struct cml_surface_set *start_as, struct cml_owned_world *to,
                                         struct cml_error *err);

/* Returns a vector rounded to `real`. */
static inline struct cml_vec cml_vec_of(double x, double y, double z)
{
    const struct cml_vec v = {(real)x, (real)y, (real)z};
    return v;
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
