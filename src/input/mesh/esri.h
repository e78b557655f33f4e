/* Reader of ESRI ASCII grid (.asc) files. The format: keywords with one number each (ncols nrows, xllcorner
 * yllcorner or xllcenter yllcenter, cellsize or dx dy, NODATA_value), in any case and order; then ncols *
 * nrows heights, top row first, broken into lines anywhere. SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "scene/heightmap/heightmap.h"

/* Reads `path` from `source` (NULL: the file system) as a map, centred at x = y = 0, in cm; the corner in the
 * file is not used. unit: cm per unit of all lengths; 0 is refused, because the file has no units. Cells of
 * NODATA_value (-9999 unless given) or nan are missing. Free the map with cml_heightmap_clear. CML_E_INPUT:
 * the map is cleared. */
CML_NODISCARD cml_status cml_esri_read(const struct cml_text_source *source, const char *path, double unit,
                                       struct cml_heightmap *map, struct cml_error *err);
