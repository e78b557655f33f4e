/* The lines of .mci files that ask for more than original MCML tallies: map, facets, time,
 * directions, fluence and photons.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the current line "map nx ny dx dy [angles] [volume] [top=z]", cursor behind the keyword. */
CML_NODISCARD cml_status cml_mci_map(struct cml_mci_reader *reader, struct cml_map_def *map);

/* Reads the current line "facets", cursor behind it. */
CML_NODISCARD cml_status cml_mci_facets(struct cml_mci_reader *reader, int *facets);

/* Reads the current line "time T1 N", cursor behind the keyword. */
CML_NODISCARD cml_status cml_mci_time(struct cml_mci_reader *reader, struct cml_time_def *time);

/* Reads the current line "fluence". */
CML_NODISCARD cml_status cml_mci_fluence(struct cml_mci_reader *reader, struct cml_fluence_def *fluence);

/* When the run's grid is known: refuses a fluence of too many bins. */
CML_NODISCARD cml_status cml_mci_check_fluence(const struct cml_mci_reader *reader,
                                               const struct cml_scene *scene);

/* Reads the current line "directions NT NP", cursor behind the keyword. */
CML_NODISCARD cml_status cml_mci_directions(struct cml_mci_reader *reader,
                                            struct cml_directions_def *directions);

/* Reads the current line "photons NAME [detected] [limit=N]", cursor behind the keyword. */
CML_NODISCARD cml_status cml_mci_photons(struct cml_mci_reader *reader, struct cml_saved_def *saved);

/* When the run's detectors are known: refuses `detected` where there are none. */
CML_NODISCARD cml_status cml_mci_check_photons(const struct cml_mci_reader *reader,
                                               const struct cml_scene *scene);

/* Once nz and na are known: refuses more cells in maps and volume than an array may have, in figures. */
CML_NODISCARD cml_status cml_mci_check_map(const struct cml_mci_reader *reader,
                                           const struct cml_scene *scene);
