/* The numbers of a medium, n mua mus g, that lines of layers and of bodies have in common, and the line
 * behind them that says how it scatters; how rough surfaces are; and what lies under the last one.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* A line `phase` behind layer `layer`, or behind the last body in it. The medium shares its function with the
 * media before it that have an equal one. */
CML_NODISCARD cml_status cml_mci_phase(struct cml_mci_reader *reader, int layer, struct cml_scene *scene);

/* The keys of a phase function; CML_KEYS_NONE: it has no numbers, or there is none. */
enum cml_key_group cml_mci_phase_keys(const struct cml_phase *phase);

/* *own: medium m's phase function, which it shares with no other medium from then on. */
CML_NODISCARD cml_status cml_mci_own_phase(const struct cml_mci_reader *reader, struct cml_scene *scene,
                                           int m, struct cml_phase **own);

/* After all numbers are there. Refuses an absorption that would be lost in rounding: mua's setting is named
 * where there is one, else the line; and a phase function whose mean cosine is not the medium's g to 1e-3. */
CML_NODISCARD cml_status cml_mci_check_media(const struct cml_mci_reader *reader,
                                             const struct cml_scene *scene);

/* A line `backing`: what lies under the last boundary. */
CML_NODISCARD cml_status cml_mci_backing(struct cml_mci_reader *reader, struct cml_backing_def *backing);

/* Reads the current rough line of boundary `index`. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_rough_line(struct cml_mci_reader *reader, int index,
                                            struct cml_rough_def *rough);

/* "ggx,0.2" of a body's option. False: it is no such thing. */
bool cml_mci_parse_rough(const char *text, struct cml_rough_def *rough);

/* When all lines are read: CML_E_INPUT for a rough line beside a lambertian backing. */
CML_NODISCARD cml_status cml_mci_check_rough(const struct cml_mci_reader *reader,
                                             const struct cml_scene *scene);
