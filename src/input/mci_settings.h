/* What may be set from outside the file (base/settings.h), and by which names:
 *     photons
 *     above.n  below.n  layerL.n  layerL.mua  layerL.mus  layerL.g  layerL.d     layers from 1
 *     bodyK.n  bodyK.mua  bodyK.mus  bodyK.g                                     bodies from 1
 *     NAME.n ...                      of a layer that has a name, as gel.mua, beside its number
 *     layerL.phase.g1 .g2 .w .g .a  bodyK.phase...       the numbers of a phase line
 *     backing.r, or of a metal backing.n  backing.k
 *     boundaryB.scale  boundaryB.height       boundaries from 0; of those that have a shape in the file
 *     beam.x  .y  .z  .angle  .azimuth  .na  .share and, by shape, .radius, .r1  .r2  or  .w  .h     of what
 * the line has; cm, degrees. Of several beams beam1.x ...
 *     detector.x  .y  .z, with na= .na  .angle  .azimuth, and .radius, .r1  .r2, .w  .h  or  .dx  .dy
 * Of several detectors detector1.x ... A value takes the place of the file's when all lines are read: it is
 * held against the range of the field, and what belongs together is checked after that. Only shapes are read
 * with their settings. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* The factors of the shape of boundary b as they are set; those that are not stay as they are. */
CML_NODISCARD cml_status cml_mci_set_scaling(const struct cml_mci_reader *reader, int b, double *scale,
                                             double *height);

/* Puts all settings in the place of what the file says. CML_E_INPUT when a value is not in the field's range,
 * or the scene has no such number; the message has the names that it knows. */
CML_NODISCARD cml_status cml_mci_apply_settings(struct cml_mci_reader *reader, struct cml_scene *scene);

/* Whether the scene has a number of that name, which a setting may take the place of. *known is false on
 * failure, which is want of memory. */
CML_NODISCARD cml_status cml_mci_is_setting(const struct cml_scene *scene, const char *name, bool *known,
                                            struct cml_error *err);

/* The layer that a setting is of, by number or name; 0: of none. */
int cml_mci_layer_of(const struct cml_scene *scene, const char *name);

/* Takes name=NAME, which may stand behind the numbers of layer `layer`, off the current line. The name is the
 * scene's from then on. CML_E_INPUT: a word that is no name, or one that something else has. */
CML_NODISCARD cml_status cml_mci_layer_name(struct cml_mci_reader *reader, const char *owner, int layer,
                                            struct cml_scene *scene);

/* Whether a word that is no setting of a scene was perhaps meant for one: it has a dot, begins like the owner
 * of numbers (layer1_mua), or is nearly the name of a number (mua). */
bool cml_mci_resembles_setting(const char *name);
