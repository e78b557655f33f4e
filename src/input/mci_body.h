/* Reader of `i` lines of .mci files: bodies inside the layer whose line stands before.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the rest of an `i` line into a new last body of the scene and its medium. layer: the layer that it
 * lies in, 1..L. The body's host is not known yet (cml_scene_place_bodies). */
CML_NODISCARD cml_status cml_mci_body(struct cml_mci_reader *reader, int layer, struct cml_scene *scene);
