/* Reader of the .h5 files that a run writes (output/report_fields.c names their data sets): as a result, like
 * one from an .mco file, or one map of it. Shapes of boundaries are not in them. SPDX-License-Identifier: MIT
 */
#ifndef CML_HDF5_RESULT_H
#define CML_HDF5_RESULT_H

#include "output/mco.h"
#include "plot/files/vti.h"

/* Totals, profiles, grids and, in `extra`, standard errors, sampling, seed and run as an .mco file has them.
 * A_z and A_rz are 0 where absorption was not tallied. A program without HDF5 refuses every file. CML_E_INPUT
 * with file and data set; then *mco is cleared. The caller clears it otherwise. */
CML_NODISCARD cml_status cml_hdf5_read_result(const char *path, struct cml_mco *mco, struct cml_error *err);

enum { CML_HDF5_UNIT = 32 };

/* The data set of this name over y and x, and its unit, "" when it has none. CML_E_INPUT with file and data
 * set; then *map is cleared. The caller clears it otherwise. */
CML_NODISCARD cml_status cml_hdf5_read_map(const char *path, const char *name, struct cml_pixels *map,
                                           char unit[CML_HDF5_UNIT], struct cml_error *err);

#endif
