/* Reader and writer of Gwyddion Simple Field (.gsf) files. The format: a first line with the name of the
 * format, lines `name = value`, 1 to 4 NUL bytes up to a multiple of 4, then XRes * YRes heights as 32-bit
 * floats, lowest byte first, top row first [Gwyddion user guide, "Simple Field Files"]. The reader is strict:
 * it refuses a deviation with its line or byte. SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "scene/heightmap/heightmap.h"

/* Reads `path` from `source` (NULL: the file system) as a map, centred at x = y = 0, in cm; offsets in the
 * file are not used. unit: cm per unit for a file without units, refused for others; 0: none given. Free the
 * map with cml_heightmap_clear. CML_E_INPUT: the map is cleared. */
CML_NODISCARD cml_status cml_gsf_read(const struct cml_text_source *source, const char *path, double unit,
                                      struct cml_heightmap *map, struct cml_error *err);

/* Reads an image in the way of cml_gsf_read. Values stay unchanged, whatever their unit. XReal and YReal need
 * XYUnits. */
CML_NODISCARD cml_status cml_gsf_read_pixels(const struct cml_text_source *source, const char *path,
                                             struct cml_heightmap *map, struct cml_error *err);

/* Writes a map that cml_gsf_read can read: heights in single precision, lengths in cm, without the map's
 * position. Atomic. CML_E_IO. */
CML_NODISCARD cml_status cml_gsf_write(const char *path, const struct cml_heightmap *map,
                                       struct cml_error *err);
