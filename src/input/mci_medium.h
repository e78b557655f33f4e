/* The numbers of a medium, n mua mus g, that lines of layers and of bodies have in common, and the line
 * behind them that says how it scatters; how rough surfaces are; and what lies under the last one.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

#define CML_MCI_MEDIUM_FIELDS 4

extern const struct cml_mci_field cml_mci_medium_fields[CML_MCI_MEDIUM_FIELDS]; /* n, mua, mus, g */

extern const struct cml_mci_field cml_mci_thickness; /* d, of a layer */

/* The medium of the current line, of n, mua, mus, g; d stays 0. */
struct cml_medium_def cml_mci_medium(const struct cml_mci_reader *reader,
                                     const double line[CML_MCI_MEDIUM_FIELDS]);

/* Takes name=NAME, which may stand behind the numbers of layer `layer`, off the current line. The name is the
 * scene's from then on. CML_E_INPUT: a word that is no name, or one that something else has. */
CML_NODISCARD cml_status cml_mci_layer_name(struct cml_mci_reader *reader, const char *owner, int layer,
                                            struct cml_scene *scene);

/* A line `phase` behind layer `layer`, or behind the last body in it. The medium shares its function with the
 * media before it that have an equal one. */
CML_NODISCARD cml_status cml_mci_phase(struct cml_mci_reader *reader, int layer, struct cml_scene *scene);

/* Where medium m has the number `member`, as of layer2.mua or layer2.phase.g1, whose phase function is its
 * own from then on. */
CML_NODISCARD cml_status cml_mci_medium_number(struct cml_mci_reader *reader, struct cml_scene *scene, int m,
                                               const char *member, struct cml_mci_number *number);
struct cml_mci_number cml_mci_backing_number(struct cml_backing_def *backing, const char *member);

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

/* What such a text is expected to be. */
extern const char cml_mci_rough_option[];

/* When all numbers are set: CML_E_INPUT for an alpha that is too small, or beside a lambertian backing. */
CML_NODISCARD cml_status cml_mci_check_rough(const struct cml_mci_reader *reader,
                                             const struct cml_scene *scene);

/* The number "alpha" for settings; value NULL: there is no such number. */
struct cml_mci_number cml_mci_rough_number(struct cml_rough_def *rough, const char *member);
