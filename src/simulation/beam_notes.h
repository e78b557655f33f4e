/* Notes of `check` and `run` on beams and the surfaces that they meet. SPDX-License-Identifier: MIT */
#pragma once

#include "surface/surface.h"

/* Shows notes on standard error, as "FILE:LINE: ...", in these cases. The axis of a beam passes a boundary
 * beyond its mesh. The map reaches beyond a mesh. A pencil meets a rough surface at one point. A rectangle
 * lights a tile unevenly. Light starts in a clear layer that traps it, or beyond all layers and leads away.
 * surfaces: the surfaces of the flight. *starts: the media of cml_source_media, which the caller frees;
 * starts NULL: not wanted. CML_E_INPUT as cml_source_media. */
CML_NODISCARD cml_status cml_note_beam(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                       int **starts, struct cml_error *err);

/* Checks before any flight that all beams may start where they do: not on a surface, not below a backing, and
 * with an aperture that the medium allows. Makes the surfaces if a beam has z=. */
CML_NODISCARD cml_status cml_check_starts(const struct cml_scene *scene,
                                          const struct cml_surface_options *options, struct cml_error *err);
