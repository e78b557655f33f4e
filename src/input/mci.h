/* Reader of .mci files: the grammar of original MCML, and keyword lines of our own (b, m, rough, i, phase,
 * backing, beam, map, facets, time, directions, fluence, detector, photons), bare or behind "#@ ".
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/input_options.h"
#include "scene/scene.h"

/* Reads all runs of `path` ("-": standard input) and the files they name. options NULL: all zero. Every scene
 * has passed all checks but cml_scene_check_shapes, which takes time and is left to the caller. CML_E_INPUT:
 * the message has file, line, field, value and what was expected; *list is cleared. Limits: 32767 runs, 1e5
 * layers, 2^31 cells in all arrays of a run, 1e7 samples per heightfield, n 0.01..100, lengths and
 * coefficients up to 1e30. Text behind the last run is ignored, as in original MCML, unless it begins with a
 * keyword line. */
CML_NODISCARD cml_status cml_mci_read(const char *path, const struct cml_input_options *options,
                                      struct cml_scene_list *list, struct cml_error *err);

/* Copies a scene with other settings, and with the result's name from the options if they have one. The
 * settings replace those with which the scene was read. The copy shares shapes, bodies and tables; only
 * shapes whose scale or height changes are read again, from options->source. Checks are as in cml_mci_read;
 * on failure *scene is empty. */
CML_NODISCARD cml_status cml_mci_copy(const struct cml_scene *from, const struct cml_input_options *options,
                                      struct cml_scene *scene, struct cml_error *err);
