/* What `check` and `run` note of a beam and the surfaces that it meets. SPDX-License-Identifier: MIT */
#ifndef CML_BEAM_NOTES_H
#define CML_BEAM_NOTES_H

#include "surface/surface.h"

/* Notes on standard error, each "FILE:LINE: ...": the beam's axis passes a boundary beyond its mesh; the map
 * reaches beyond a mesh; a pencil meets a mesh or a map at one point, so that results are of that point;
 * light starts in a clear layer that traps it. surfaces: those that the scene is flown with. CML_E_INPUT when
 * memory runs out, or a beam starts on a surface. */
CML_NODISCARD cml_status cml_note_beam(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                       struct cml_error *err);

#endif
