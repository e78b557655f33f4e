/* Reader of the lines `map` and `photons` of .mci files, and checks of map, photons and fluence against the
 * rest of a run. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

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
