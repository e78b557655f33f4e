/* What may be set from outside the file (base/settings.h), and by which names:
 *     photons
 *     above.n  below.n  layerL.n  layerL.mua  layerL.mus  layerL.g  layerL.d     layers from 1
 *     bodyK.n  bodyK.mua  bodyK.mus  bodyK.g                                     bodies from 1
 *     layerL.phase.g1 .g2 .w .g .a  bodyK.phase...       the numbers of a phase line
 *     backing.r, or of a metal backing.n  backing.k
 *     boundaryB.scale  boundaryB.height       boundaries from 0; of those that have a shape in the file
 *     beam.x  .y  .z  .angle  .azimuth  .na  .share and, by shape, .radius, .r1  .r2  or  .w  .h     of what
 * the line has; cm, degrees. Of several beams beam1.x ...
 *     detector.x  .y  .z, with na= .na  .angle  .azimuth, and .radius, .r1  .r2, .w  .h  or  .dx  .dy
 * Of several detectors detector1.x ... The reader asks for every name where it reads the
 * field, and takes the value in place of the file's: so both pass the same checks, and a setting that nobody
 * has asked for is no name of this scene. SPDX-License-Identifier: MIT */
#ifndef CML_MCI_SETTINGS_H
#define CML_MCI_SETTINGS_H

#include "input/mci_lines.h"
#include "scene/scene.h"

/* The setting of the name that the format makes, which counts as taken from here on; NULL: none. */
CML_PRINTF(2, 3)
const struct cml_setting *cml_mci_setting(struct cml_mci_reader *reader, const char *format, ...);

/* Puts the setting's number, if there is a setting, in the place of *value. CML_E_INPUT when it is not in the
 * field's range. */
CML_NODISCARD cml_status cml_mci_set(const struct cml_mci_reader *reader, const struct cml_setting *setting,
                                     const struct cml_mci_field *field, double *value);

/* After a run was read: CML_E_INPUT when a setting was not taken, with the names that this run knows. */
CML_NODISCARD cml_status cml_mci_check_settings(const struct cml_mci_reader *reader,
                                                const struct cml_scene *scene);

#endif
