/* Names of the numbers of a scene that --set and sweeps may change (base/settings.h):
 *
 *   photons
 *   above.n  below.n  layerL.n  layerL.mua  layerL.mus  layerL.g  layerL.d     layers from 1
 *   bodyK.n  bodyK.mua  bodyK.mus  bodyK.g                                     bodies from 1
 *   NAME.n ...                   the numbers of a layer that has a name, as gel.mua
 *   layerL.phase.g1 .g2 .w .g .a  bodyK.phase...       the numbers of a phase line
 *   backing.r, or for a metal backing.n  backing.k
 *   boundaryB.scale  boundaryB.height       boundaries from 0 that have a shape in the file
 *   beam.x  .y  .z  .angle  .azimuth  .na  .share and, by shape, .radius, .r1  .r2  or  .w  .h
 *     if the line has them; cm, degrees. With several beams: beam1.x ...
 *   detector.x  .y  .z, with na= .na  .angle  .azimuth, and .radius, .r1  .r2, .w  .h  or  .dx  .dy
 *     With several detectors: detector1.x ...
 *
 * A setting replaces the file's value when all lines are read. It must be in the range of the field, and the
 * checks of several lines follow after it. Shapes are the exception: their settings are applied while they
 * are read. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Replaces *scale and *height of boundary b by their settings, if there are any. */
CML_NODISCARD cml_status cml_mci_set_scaling(const struct cml_mci_reader *reader, int b, double *scale,
                                             double *height);

/* Replaces values of the file by all settings. CML_E_INPUT: a value outside the range of its field, or an
 * unknown name; the message lists the names of this scene. */
CML_NODISCARD cml_status cml_mci_apply_settings(struct cml_mci_reader *reader, struct cml_scene *scene);

/* Sets *known to true if a setting may have this name in the scene. Fails only for want of memory; *known is
 * false then. */
CML_NODISCARD cml_status cml_mci_is_setting(const struct cml_scene *scene, const char *name, bool *known,
                                            struct cml_error *err);

/* Returns the number of the layer that a setting's name means, by number or name; 0: no layer. */
int cml_mci_layer_of(const struct cml_scene *scene, const char *name);

/* Takes the word name=NAME, which may stand behind the numbers of a layer, off the current line, and gives
 * the layer this name. CML_E_INPUT: an invalid name, or one that is in use. */
CML_NODISCARD cml_status cml_mci_layer_name(struct cml_mci_reader *reader, const char *owner, int layer,
                                            struct cml_scene *scene);

/* True if a word that is not a setting was perhaps meant as one: it has a dot, begins like an owner
 * (layer1_mua), or resembles the name of a number (mua). */
bool cml_mci_resembles_setting(const char *name);
