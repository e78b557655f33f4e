/* Reader of the maps of .h5 files. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>

enum { CML_HDF5_UNIT = 32 };

/* n[0] x n[1] pixels along x and y, x fastest; lengths in cm. */
struct cml_pixels {
    size_t n[2];
    double origin[2], spacing[2]; /* corner of the first pixel, size of a pixel */
    float *value;                 /* [n[1]][n[0]], finite, >= 0, owned */
};

void cml_pixels_clear(struct cml_pixels *pixels);

/* A level cut through voxels, across `axis`: 'x', 'y' or 'z', or 0 for none. */
struct cml_voxel_cut {
    char axis;
    double at; /* cm */
};

/* Whether the data set of this name is over voxels. */
bool cml_hdf5_is_volume(const char *name);

/* The data set of this name over y and x, or of voxels those that the cut meets, over x or y and, but for a
 * cut across z, z; a detector's map over those of its own, and its unit, "" when it
 * has none. else_known: the names that the caller knows of what is no map, for the message. A program without
 * HDF5 refuses every file. CML_E_INPUT with file and data set; then *map is cleared. The caller clears it
 * otherwise. */
CML_NODISCARD cml_status cml_hdf5_read_map(const char *path, const char *name,
                                           const struct cml_voxel_cut *cut, const char *else_known,
                                           struct cml_pixels *map, char unit[CML_HDF5_UNIT],
                                           struct cml_error *err);
