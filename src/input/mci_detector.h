/* Reader of the lines `detector`, `map` and `photons` of .mci files, and checks of them and of fluence
 * against the rest of a run. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the current line "detector SHAPE [at=x,y] [z=z] [side=top|bottom] [na=N] [angle=degrees]
 * [azimuth=degrees] [diffuse] [name=NAME]", with the cursor behind the keyword. Angles become rad. Also reads
 * "detector table FILE", a file whose rows have the words of such lines without the keyword. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_detector(struct cml_mci_reader *reader, struct cml_scene *scene);

/* Lists the groups of keys of a detector that may be set, at most CML_MOST_KEY_PARTS, in `part`. A detector
 * that sees all directions has no keys of an axis. */
void cml_mci_detector_parts(struct cml_detector_def *detector, struct cml_key_part *part);

/* Fills in names and planes that the lines do not give, and checks the detectors together. Call it when all
 * numbers are known. CML_E_INPUT: two detectors of one name, or too many pixels. */
CML_NODISCARD cml_status cml_mci_end_detectors(const struct cml_mci_reader *reader, struct cml_scene *scene);

/* Reads the current line "map nx ny dx dy [angles] [volume] [top=z]", with the cursor behind the keyword. */
CML_NODISCARD cml_status cml_mci_map(struct cml_mci_reader *reader, struct cml_scene *scene);

/* Refuses a fluence of too many bins. Call it when the grid of the run is known. */
CML_NODISCARD cml_status cml_mci_check_fluence(const struct cml_mci_reader *reader,
                                               const struct cml_scene *scene);

/* Reads the current line "photons NAME [detected] [limit=N]", with the cursor behind the keyword. */
CML_NODISCARD cml_status cml_mci_photons(struct cml_mci_reader *reader, struct cml_scene *scene);

/* Refuses `detected` in a run without detectors. Call it when the detectors are known. */
CML_NODISCARD cml_status cml_mci_check_photons(const struct cml_mci_reader *reader,
                                               const struct cml_scene *scene);

/* Refuses a map and volume of more than 2^31 cells together. Call it when nz and na are known. */
CML_NODISCARD cml_status cml_mci_check_map(const struct cml_mci_reader *reader,
                                           const struct cml_scene *scene);
