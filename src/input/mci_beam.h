/* The beam lines of .mci files. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Adds a pencil beam: there is one without a line. */
CML_NODISCARD cml_status cml_mci_add_beam(struct cml_mci_reader *reader, struct cml_scene *scene);

/* Reads the current line "beam SHAPE [at=x,y] [z=z] [angle=degrees] [azimuth=degrees] [light=LIGHT] [share=s]
 * [radial=beam]", cursor behind the keyword, and the files that it names; angles become rad. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_beam(struct cml_mci_reader *reader, struct cml_scene *scene);

/* What beam k has keys of, at most CML_MOST_KEY_PARTS. in_line: also those that its line may have. */
void cml_mci_beam_parts(struct cml_scene *scene, int k, bool in_line, struct cml_key_part *part);

/* After all numbers are there: gives rectangles of tiles their size, and checks what lines and media have to
 * do with each other. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_check_beams(const struct cml_mci_reader *reader, struct cml_scene *scene);
