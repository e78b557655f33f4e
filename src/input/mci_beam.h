/* Reader of `beam` lines of .mci files. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Adds a pencil beam to the scene; a scene without a `beam` line has one. */
CML_NODISCARD cml_status cml_mci_add_beam(struct cml_mci_reader *reader, struct cml_scene *scene);

/* Reads the current line "beam SHAPE [at=x,y] [z=z] [angle=degrees] [azimuth=degrees] [light=LIGHT] [share=s]
 * [radial=beam]", with the cursor behind the keyword, and the files that it names. Angles become rad.
 * CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_beam(struct cml_mci_reader *reader, struct cml_scene *scene);

/* Lists the groups of keys of beam k in `part`, which has room for CML_MOST_KEY_PARTS. in_line: lists keys
 * that its line may have, too, not only those that may be set. */
void cml_mci_beam_parts(struct cml_scene *scene, int k, bool in_line, struct cml_key_part *part);

/* Gives rectangles of tiles their size, and checks beams against media and other lines. Call it when all
 * numbers are known. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_check_beams(const struct cml_mci_reader *reader, struct cml_scene *scene);
