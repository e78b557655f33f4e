/* Gwyddion Simple Field (.gsf) files: a line that says so, lines `name = value`, 1 to 4 NUL bytes up to a
 * multiple of 4, then XRes * YRes heights, 32-bit floating point, least byte first, top row first [Gwyddion
 * user guide, "Simple Field Files"]. Strict: what is not as it says is refused with line or byte.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "scene/heightmap/heightmap.h"

/* Reads `path` from `source`, NULL: from the file system. Lengths come in the file's units; `unit` (cm per
 * unit, 0: none given) is for files without any, and refused with others. Offsets are not used: the map's
 * middle lies at x = y = 0. The map is centred, in cm; free it with cml_heightmap_clear. CML_E_INPUT; then
 * the map is cleared. */
CML_NODISCARD cml_status cml_gsf_read(const struct cml_text_source *source, const char *path, double unit,
                                      struct cml_heightmap *map, struct cml_error *err);

/* Reads an image as cml_gsf_read reads a map, but values stay as they are, whatever their unit. XReal and
 * YReal need XYUnits. */
CML_NODISCARD cml_status cml_gsf_read_pixels(const struct cml_text_source *source, const char *path,
                                             struct cml_heightmap *map, struct cml_error *err);

/* Writes a map as cml_gsf_read reads it: heights in single precision, lengths in cm. The place of the map is
 * not in the file. Atomic; CML_E_IO on failure. */
CML_NODISCARD cml_status cml_gsf_write(const char *path, const struct cml_heightmap *map,
                                       struct cml_error *err);
