/* Lines map and photons of .mci files, and what they and fluence have to do with the rest of a run.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the current line "map nx ny dx dy [angles] [volume] [top=z]", cursor behind the keyword. */
CML_NODISCARD cml_status cml_mci_map(struct cml_mci_reader *reader, struct cml_scene *scene);

/* When the run's grid is known: refuses a fluence of too many bins. */
CML_NODISCARD cml_status cml_mci_check_fluence(const struct cml_mci_reader *reader,
                                               const struct cml_scene *scene);

/* Reads the current line "photons NAME [detected] [limit=N]", cursor behind the keyword. */
CML_NODISCARD cml_status cml_mci_photons(struct cml_mci_reader *reader, struct cml_scene *scene);

/* When the run's detectors are known: refuses `detected` where there are none. */
CML_NODISCARD cml_status cml_mci_check_photons(const struct cml_mci_reader *reader,
                                               const struct cml_scene *scene);

/* Once nz and na are known: refuses more cells in maps and volume than an array may have, in figures. */
CML_NODISCARD cml_status cml_mci_check_map(const struct cml_mci_reader *reader,
                                           const struct cml_scene *scene);
