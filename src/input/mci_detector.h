/* The detector lines of .mci files. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the current line "detector SHAPE [at=x,y] [z=z] [side=top|bottom] [na=N] [angle=degrees]
 * [azimuth=degrees] [diffuse] [name=NAME]", cursor behind the keyword; angles become rad. Or
 * "detector table FILE", each line of which is what stands behind the keyword. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_detector(struct cml_mci_reader *reader, struct cml_scene *scene);

/* What a detector has keys of that can be set, at most CML_MOST_KEY_PARTS: one that sees all directions has
 * no axis. */
void cml_mci_detector_parts(struct cml_detector_def *detector, struct cml_key_part *part);

/* After all numbers are there: fills in names and planes that lines do not give, and checks what lines have
 * to do with each other. CML_E_INPUT: two of a name, too many pixels. */
CML_NODISCARD cml_status cml_mci_end_detectors(const struct cml_mci_reader *reader, struct cml_scene *scene);
