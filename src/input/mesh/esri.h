/* ESRI ASCII grid (.asc) files: keywords with one number each (ncols nrows, xllcorner yllcorner or xllcenter
 * yllcenter, cellsize or dx dy, NODATA_value), in any case and order, then ncols * nrows heights, top row
 * first; line ends do not matter between them. SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "scene/heightmap/heightmap.h"

/* Reads `path` from `source`, NULL: from the file system. unit: cm per unit of all lengths; 0 (none given) is
 * refused, the file has none. The corner is not used: the map's middle lies at x = y = 0. Cells of
 * NODATA_value (-9999 unless given) or nan are missing. The map is centred, in cm; free it with
 * cml_heightmap_clear. CML_E_INPUT; then the map is cleared. */
CML_NODISCARD cml_status cml_esri_read(const struct cml_text_source *source, const char *path, double unit,
                                       struct cml_heightmap *map, struct cml_error *err);
