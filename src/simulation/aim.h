/* The aims of `run --aim`. Below all shapes, bodies and beams (the "level") a scene is flat, and the fate of
 * light there is known: its expected values need no photons (P15, the "tail"). For other aims packets are
 * split on their way (P19, "windows"):
 *
 *     ~~~~~~~~~~~~~~~~   shapes, bodies, beams: packets fly, windows split them
 *     ----------------   level
 *     ================   flat layers: the tail gives Tt_expected and A_l_expected
 *
 * SPDX-License-Identifier: MIT */
#pragma once

#include "aim/level.h"
#include "options/options.h"
#include "scene/window_table.h"
#include "scene/flat_tail.h"
#include "surface/surface.h"
#include "tally/result.h"

/* Finds the first detector that has seen nothing. Returns its number, from 1, if windows of --aim would make
 * the run faster there, which is computed; else 0. */
int cml_aim_unseen(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                   const struct cml_result *result);

/* An aim: expected values below the level if tail.scores > 0, windows if windows.cells > 0. */
struct cml_aim {
    struct cml_flat_tail tail;
    struct cml_window_table windows;
};

/* Makes the aim at NAME[,NAME...], which may be Tt, Tt_r, A_l:N and names of detectors: a tail for values
 * below the level, windows for the rest. tail false: leaves out the table of the tail, which takes longest.
 * CML_E_INPUT: "FILE:LINE: --aim A_l:1 (expected ...)". CML_E_NUMERIC: adding-doubling has no answer. On
 * success the caller clears *to. */
CML_NODISCARD cml_status cml_aim_create(const char *aim, const struct cml_scene *scene,
                                        const struct cml_surface_set *surfaces, bool tail, struct cml_aim *to,
                                        struct cml_error *err);

/* Makes the aim of --aim; empty without the option. CML_E_INPUT as cml_aim_create, and if adding-doubling has
 * no answer, because nothing flies without it, or windows stand beside --derivatives. */
CML_NODISCARD cml_status cml_aim_for_run(const struct cml_options *options, const struct cml_scene *scene,
                                         const struct cml_surface_set *surfaces, bool tail,
                                         struct cml_aim *to, struct cml_error *err);

/* Makes engines that are opened with these options use the aim. */
void cml_aim_use(const struct cml_aim *aim, struct cml_engine_options *options);

/* Returns in *of the number of the quantity that --error-of names (error_of of struct cml_run_setup); 0
 * without the option. CML_E_INPUT: the scene has no such quantity. */
CML_NODISCARD cml_status cml_find_error_of(const struct cml_options *options, const struct cml_scene *scene,
                                           int *of, struct cml_error *err);

/* Checks before any flight whether --aim is refused. Only a tail without an answer is found later, in flight.
 * shared: as in cml_surface_options. Computing windows takes some 0.08 s. */
CML_NODISCARD cml_status cml_aim_check(const struct cml_options *options, const struct cml_scene *scene,
                                       const struct cml_surface_set *shared, struct cml_error *err);

void cml_aim_clear(struct cml_aim *aim);
