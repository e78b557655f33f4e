/* What `check` and `run` note of a beam and the surfaces that it meets. SPDX-License-Identifier: MIT */
#pragma once

#include "surface/surface.h"

/* Notes on standard error, each "FILE:LINE: ...": the beam's axis passes a boundary beyond its mesh; the map
 * reaches beyond a mesh; a pencil meets a mesh or a map at one point, so that results are of that point;
 * light starts in a clear layer that traps it, or beyond all layers, which it leaves behind. surfaces: those
 * that the scene is flown with. *starts: media of cml_source_media, the caller's to free; NULL where they are
 * not wanted. CML_E_INPUT as that. */
CML_NODISCARD cml_status cml_note_beam(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                       int **starts, struct cml_error *err);

/* Whether all beams may start where they do, before anything flies: not on a surface, not below a backing,
 * and with an aperture that the medium there has room for. Costs the surfaces where a beam has z=. */
CML_NODISCARD cml_status cml_check_starts(const struct cml_scene *scene,
                                          const struct cml_surface_options *options, struct cml_error *err);
