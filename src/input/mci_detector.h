/* The detector lines of .mci files. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the current line "detector SHAPE [at=x,y] [z=z] [side=top|bottom] [na=N] [angle=degrees]
 * [azimuth=degrees] [diffuse] [name=NAME]", cursor behind the keyword; angles become rad. Or
 * "detector table FILE", each line of which is what stands behind the keyword. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_detector(struct cml_mci_reader *reader, struct cml_scene *scene);

/* Where a detector has the number `member`, as of detector.radius: of what its line has, and one that sees
 * all directions has no axis. */
struct cml_mci_number cml_mci_detector_number(struct cml_detector_def *detector, const char *member);

/* After all numbers are there: fills in names and planes that lines do not give, and checks what lines have
 * to do with each other. CML_E_INPUT: two of a name, too many pixels. */
CML_NODISCARD cml_status cml_mci_end_detectors(const struct cml_mci_reader *reader, struct cml_scene *scene);
