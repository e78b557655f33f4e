/* The detector lines of .mci files. SPDX-License-Identifier: MIT */
#ifndef CML_MCI_DETECTOR_H
#define CML_MCI_DETECTOR_H

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the current line "detector SHAPE [at=x,y] [z=z] [side=top|bottom] [na=N] [angle=degrees]
 * [azimuth=degrees] [diffuse] [name=NAME]", cursor behind the keyword; angles become rad. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_detector(struct cml_mci_reader *reader, struct cml_scene *scene);

/* Once layers and map are known: names and planes that lines do not give, and what lines have to do with each
 * other. CML_E_INPUT: two of a name, too many pixels. */
CML_NODISCARD cml_status cml_mci_end_detectors(struct cml_mci_reader *reader, struct cml_scene *scene);

#endif
