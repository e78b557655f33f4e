/* The numbers of a medium, n mua mus g, that lines of layers and of bodies have in common, and the line
 * behind them that says how it scatters; and what lies under the last one. SPDX-License-Identifier: MIT */
#ifndef CML_MCI_MEDIUM_H
#define CML_MCI_MEDIUM_H

#include "input/mci_lines.h"
#include "scene/scene.h"

#define CML_MCI_MEDIUM_FIELDS 4

extern const char cml_mci_index_range[];                                        /* of n, in words */
extern const struct cml_mci_field cml_mci_medium_fields[CML_MCI_MEDIUM_FIELDS]; /* n, mua, mus, g */

/* The medium of a line of these values, or of what is set in their place; kind and number: "layer", 2 of
 * "layer 2" in messages and of the setting layer2.mua. Refuses an absorption that would be lost in rounding:
 * mua's setting is named where there is one, else the line. d stays 0. */
CML_NODISCARD cml_status cml_mci_medium(struct cml_mci_reader *reader, const char *kind, int number,
                                        const double line[CML_MCI_MEDIUM_FIELDS],
                                        struct cml_medium_def *medium);

/* A line `phase` behind layer `layer`, or behind the last body in it. The medium shares its function with the
 * media before it that have an equal one. CML_E_INPUT also where the mean cosine is not the medium's g to
 * 1e-3.
 */
CML_NODISCARD cml_status cml_mci_phase(struct cml_mci_reader *reader, int layer, struct cml_scene *scene);

/* A line `backing`: what lies under the last boundary. */
CML_NODISCARD cml_status cml_mci_backing(struct cml_mci_reader *reader, struct cml_backing_def *backing);

#endif
