/* The trial that finds which curved boundaries may be flown as planes: packets are flown both ways and
 * compared.
 *
 *      as it is   ___.-._____.--.___   --> results --+
 *                                                    +--> differences in totals, profiles, bins: below
 * tolerance? as planes  __________________   --> results --+
 *
 * No formula is known that bounds the effect of a small height or slope on every total and profile. Grazing
 * and nearly totally reflected light, long paths through clear layers and many reflections all magnify it. So
 * the effect is measured, with the same random numbers for both ways: most packets then end alike, and few
 * are needed to see the rest of the difference.
 * The trial has a seed of its own. Its outcome depends only on the scene, the tolerance and --no-reentry, so
 * all seeds, ranks, engines and commands fly the same surfaces.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"

/* Least share of the light by which a difference is divided. The trial compares Rsp, Rd, A and Tt, the
 * profiles Rd_r, Tt_r, Rd_a, Tt_a and A_z on the scene's grid, and A_l and A_body as profiles whose bins are
 * layers and bodies.
 * Differences are relative. A total's difference is divided by the total. A profile's difference, summed over
 * its bins without sign, is divided by its whole. A bin's difference is divided by the bin, or by the
 * profile's average bin if that is more. A total or profile below this share counts as this share. */
#define CML_TRIAL_LEAST_SHARE 0.01

/* Turns curved boundaries into planes, from top to bottom, where a plane does no harm. The plane lies where
 * the boundary goes on outside its mesh or profile. A plane does no harm if every total, profile and bin of
 * the scene with this plane, and with the planes made before, differs by less than the tolerance from the
 * scene as it is. Three standard errors are added to the measured difference, and for totals and profiles the
 * share of light that so few packets may have missed altogether.
 * Trial packets fly until the answer is certain: no harm, or a larger difference. They end without an
 * answer when they have taken as many steps as fit into about a second. Unless the answer is no harm, the
 * surface stays. `reason` of a boundary tells the outcome. The function does nothing unless
 * options->may_flatten is set and force is CML_SURFACE_AUTO. It does nothing in scenes with facets either,
 * because a plane has none of the facets that the user asks for by number. engine: "cpu". After a failure
 * the set must be freed. */
CML_NODISCARD cml_status cml_make_harmless_planes(const struct cml_scene *scene,
                                                  const struct cml_surface_options *options,
                                                  const struct cml_engine *engine,
                                                  const struct cml_engine_options *engine_options,
                                                  struct cml_surface_set *surfaces, struct cml_error *err);
