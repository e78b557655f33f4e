/* What the files share that make a world: world.c, and those of its bodies and sources. Private to them.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/world.h"

/* world_bodies.c's part of cml_owned_world_create: allocates and fills what a world has of bodies, and their
 * media and surfaces, which come behind those of the layers. */
CML_NODISCARD cml_status cml_copy_bodies(const struct cml_scene *scene, const struct cml_surface_set *set,
                                         struct cml_owned_world *to, struct cml_error *err);

/* world_detectors.c's part: detectors and the grids over them. windows: of the run, or NULL. */
CML_NODISCARD cml_status cml_set_detectors(const struct cml_scene *scene,
                                           const struct cml_surface_set *surfaces,
                                           const struct cml_window_table *windows, struct cml_owned_world *to,
                                           struct cml_error *err);

/* world_sources.c's part, after all others: where packets start. start_as: as in cml_engine_options.
 * CML_E_INPUT: a beam starts within rounding of a surface, or has a larger numerical aperture than the medium
 * that it starts in. */
CML_NODISCARD cml_status cml_set_sources(const struct cml_scene *scene,
                                         const struct cml_surface_set *surfaces,
                                         const struct cml_surface_set *start_as, struct cml_owned_world *to,
                                         struct cml_error *err);

/* A vector rounded to `real`. */
static inline struct cml_vec cml_vec_of(double x, double y, double z)
{
    const struct cml_vec v = {(real)x, (real)y, (real)z};
    return v;
}

/* The optics of a medium. All quotients are taken in double and rounded once. absorb: kernels/types.h says
 * why it is a little over 1 where nothing scatters. */
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
