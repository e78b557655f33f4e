/* Weight windows: the weight that packets should have at each depth, or at each distance from a detector, so
 * that more packets reach the target (P19). SPDX-License-Identifier: MIT */
#pragma once

#include "scene/window_table.h"
#include "surface/surface.h"

/* Refuses an aim: CML_E_INPUT with the message "FILE:LINE: --aim AIM (expected ...)". The first `length`
 * bytes of `aim` are printed. */
CML_NODISCARD cml_status cml_aim_refuse(const struct cml_scene *scene, const char *aim, int length,
                                        const char *expected, struct cml_error *err);

/* Makes windows for light that leaves below the first `layers` layers. media: media of the scene with planes
 * in place of all shapes. Returns CML_E_INPUT if almost no light gets there, or CML_E_NUMERIC. On success the
 * caller clears *windows. */
CML_NODISCARD cml_status cml_windows_below(const char *aim, const struct cml_scene *scene,
                                           const struct cml_medium_def *media, int layers,
                                           struct cml_window_table *windows, struct cml_error *err);

/* Makes windows for light that detector `number`, from 1, sees. media: media of the scene with planes in
 * place of all shapes. Returns CML_E_INPUT if almost no light gets there or memory runs out, or
 * CML_E_NUMERIC. On success the caller clears *windows. */
CML_NODISCARD cml_status cml_windows_at(const char *aim, const struct cml_scene *scene,
                                        const struct cml_surface_set *surfaces,
                                        const struct cml_medium_def *media, int number,
                                        struct cml_window_table *windows, struct cml_error *err);
