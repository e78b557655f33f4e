/* The beam line of .mci files. SPDX-License-Identifier: MIT */
#ifndef CML_MCI_BEAM_H
#define CML_MCI_BEAM_H

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the current line "beam pencil|disk R|gaussian R [at=x,y] [angle=degrees] [azimuth=degrees]", cursor
 * behind the keyword; angles become rad. CML_E_INPUT, also for a second beam line of a run. */
CML_NODISCARD cml_status cml_mci_beam(struct cml_mci_reader *reader, struct cml_beam *beam);

/* Takes the settings of the beam, after its line if there is one. */
CML_NODISCARD cml_status cml_mci_beam_settings(struct cml_mci_reader *reader, struct cml_beam *beam);

#endif
