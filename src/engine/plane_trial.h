/* Which curved boundaries may be flown as planes, found by flying trial packets both ways.
 * No formula is known that bounds what a small height or slope does to every total and profile: grazing and
 * nearly totally reflected light, long paths through clear layers and many reflections all magnify it. So it
 * is measured, with the same random numbers for both ways: most packets then end alike, and what is left of
 * the difference is seen with few. The trial has a seed of its own, so that its outcome depends on the scene,
 * the tolerance and --no-reentry only: all seeds, ranks, engines and commands fly the same surfaces.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"

/* What the trial compares: Rsp, Rd, A and Tt, the profiles Rd_r, Tt_r, Rd_a, Tt_a and A_z on the scene's
 * grid, and likewise A_l and A_body, whose bins are layers and bodies. Differences are relative: of a total
 * to itself; of a profile, summed over its bins without sign, to the whole; of a bin to what it holds, or to
 * the profile's average bin where that is more. A total or profile that holds less than this share of the
 * light counts as this share. */
#define CML_TRIAL_LEAST_SHARE 0.01

/* Boundaries from top to bottom become the plane in which they go on outside, each if the scene with it and
 * the planes already made differs from the scene as it is by less than the tolerance in every total, profile
 * and bin. Three standard errors are added to what was measured, and to totals and profiles what so few
 * packets may have missed altogether. Trial packets are flown until that is so, or something is seen to
 * differ by more, or they have taken the steps of about a second. Then the surface stays. `reason` of a
 * boundary says the outcome. Does nothing unless options->may_flatten and force is CML_SURFACE_AUTO, nor in
 * scenes with facets, which are asked for by number and which a plane has none of. engine: "cpu". On failure
 * the set is to be freed. */
CML_NODISCARD cml_status cml_make_harmless_planes(const struct cml_scene *scene,
                                                  const struct cml_surface_options *options,
                                                  const struct cml_engine *engine,
                                                  const struct cml_engine_options *engine_options,
                                                  struct cml_surface_set *surfaces, struct cml_error *err);
