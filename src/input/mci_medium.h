/* Readers of keyword lines about media and surfaces: phase (scattering of the layer or body before), rough
 * (roughness of a boundary) and backing (the surface under the last boundary). SPDX-License-Identifier: MIT
 */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads a `phase` line behind layer `layer`, or behind the last body in it. The medium shares an equal phase
 * function with the media before. */
CML_NODISCARD cml_status cml_mci_phase(struct cml_mci_reader *reader, int layer, struct cml_scene *scene);

/* Returns the group of keys of a phase function; CML_KEYS_NONE: phase is NULL or has no numbers. */
enum cml_key_group cml_mci_phase_keys(const struct cml_phase *phase);

/* Returns medium m's phase function in *own, and makes a copy first if other media share it. */
CML_NODISCARD cml_status cml_mci_own_phase(const struct cml_mci_reader *reader, struct cml_scene *scene,
                                           int m, struct cml_phase **own);

/* Checks the media when all numbers are known. Refuses an absorption that rounding would lose (the message
 * names the setting of mua if there is one, else the line), and a phase function whose mean cosine differs
 * from the medium's g by more than 1e-3. */
CML_NODISCARD cml_status cml_mci_check_media(const struct cml_mci_reader *reader,
                                             const struct cml_scene *scene);

/* Reads a `backing` line: the surface under the last boundary. */
CML_NODISCARD cml_status cml_mci_backing(struct cml_mci_reader *reader, struct cml_backing_def *backing);

/* Reads the current `rough` line of boundary `index`. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_rough_line(struct cml_mci_reader *reader, int index,
                                            struct cml_rough_def *rough);

/* Reads the value of a body's option rough, "ggx,0.2"; false if it is invalid. */
bool cml_mci_parse_rough(const char *text, struct cml_rough_def *rough);

/* Refuses a `rough` line of the last boundary beside a lambertian backing: CML_E_INPUT. Call it when all
 * lines are read. */
CML_NODISCARD cml_status cml_mci_check_rough(const struct cml_mci_reader *reader,
                                             const struct cml_scene *scene);
