/* Reader of .mci files: original MCML's grammar plus the lines b, m, beam, map and facets, bare or behind "#@
 * ". SPDX-License-Identifier: MIT */
#pragma once

#include "input/input_options.h"
#include "scene/scene.h"

/* Reads all runs of `path` ("-" is standard input) and the files they name; options NULL: all zero. Every
 * scene has passed all checks but cml_scene_check_shapes, which costs time and is the caller's. CML_E_INPUT
 * names file, line, field, value and what was expected. On failure *list is cleared. Limits: 32767 runs, 1e5
 * layers, 2^31 cells in all arrays of a run, 1e7 samples per heightfield, n 0.01..100, lengths and
 * coefficients up to 1e30. What follows the last run is ignored, as in the original, unless a boundary line
 * comes first. */
CML_NODISCARD cml_status cml_mci_read(const char *path, const struct cml_input_options *options,
                                      struct cml_scene_list *list, struct cml_error *err);

/* A scene that was read before, with these settings in place of those that it was read with, and the result's
 * name, if there is one. Shares shapes, bodies and tables; only shapes that another scale or height is set of
 * are read again, from options->source. Checked as by cml_mci_read; on failure *scene is empty. */
CML_NODISCARD cml_status cml_mci_copy(const struct cml_scene *from, const struct cml_input_options *options,
                                      struct cml_scene *scene, struct cml_error *err);
