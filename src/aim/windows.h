/* What packets shall weigh, by depth or by distance from a detector, so that more of them get where light is
 * wanted (P19). SPDX-License-Identifier: MIT */
#pragma once

#include "scene/window_table.h"
#include "surface/surface.h"

/* CML_E_INPUT: "FILE:LINE: --aim AIM (expected ...)", the first `length` bytes of the aim. */
CML_NODISCARD cml_status cml_aim_refuse(const struct cml_scene *scene, const char *aim, int length,
                                        const char *expected, struct cml_error *err);

/* Windows for light that comes out of the first `layers` layers, and for what detector `number`, from 1,
 * sees. media: of the scene with planes in place of all shapes. CML_E_INPUT where next to none gets there;
 * CML_E_NUMERIC. On success the caller clears *windows. */
CML_NODISCARD cml_status cml_windows_below(const char *aim, const struct cml_scene *scene,
                                           const struct cml_medium_def *media, int layers,
                                           struct cml_window_table *windows, struct cml_error *err);
CML_NODISCARD cml_status cml_windows_at(const char *aim, const struct cml_scene *scene,
                                        const struct cml_surface_set *surfaces,
                                        const struct cml_medium_def *media, int number,
                                        struct cml_window_table *windows, struct cml_error *err);
