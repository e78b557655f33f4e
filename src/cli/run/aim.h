/* clustermcml run --aim: below all shapes, bodies and beams a scene is flat, and what becomes of light there
 * is known (P15); for what else is aimed at packets are split on their way (P19).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "aim/level.h"
#include "cli/options/options.h"
#include "scene/window_table.h"
#include "scene/flat_tail.h"
#include "surface/surface.h"
#include "tally/result.h"

/* The first detector, from 1, that has seen nothing and that --aim would send packets to, by computing its
 * windows; 0: none. */
int cml_aim_unseen(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                   const struct cml_result *result);

/* What --aim asks for: expected values below the level, where scores is not 0, windows where cells is not. */
struct cml_aim {
    struct cml_flat_tail tail;
    struct cml_window_table windows;
};

/* The aim at NAME[,NAME...], of Tt, Tt_r, A_l:N and names of detectors: the tail is for what lies below the
 * level, windows for the rest. CML_E_INPUT: "FILE:LINE: --aim A_l:1 (expected ...)"; CML_E_NUMERIC:
 * adding-doubling has no answer. On success the caller clears *to. */
CML_NODISCARD cml_status cml_aim_create(const char *aim, const struct cml_scene *scene,
                                        const struct cml_surface_set *surfaces, struct cml_aim *to,
                                        struct cml_error *err);

/* The aim that --aim asks for, none without it. CML_E_INPUT also where adding-doubling has no answer, and for
 * windows beside an option that knows none. */
CML_NODISCARD cml_status cml_aim_for_run(const struct cml_options *options, const struct cml_scene *scene,
                                         const struct cml_surface_set *surfaces, struct cml_aim *to,
                                         struct cml_error *err);

/* Flies what an engine opens with such options so. */
void cml_aim_use(const struct cml_aim *aim, struct cml_engine_options *options);

/* What --error-of names, as struct cml_run_setup wants it; 0 without it. CML_E_INPUT. */
CML_NODISCARD cml_status cml_find_error_of(const struct cml_options *options, const struct cml_scene *scene,
                                           int *of, struct cml_error *err);

/* Whether that is refused, before anything flies, but for a tail without an answer, which is found in
 * flight. shared: as in cml_surface_options. With windows it costs their computing,
 * some 0.08 s. */
CML_NODISCARD cml_status cml_aim_check(const struct cml_options *options, const struct cml_scene *scene,
                                       const struct cml_surface_set *shared, struct cml_error *err);

void cml_aim_clear(struct cml_aim *aim);
