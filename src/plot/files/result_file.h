/* A result from whatever file holds one. SPDX-License-Identifier: MIT */
#ifndef CML_RESULT_FILE_H
#define CML_RESULT_FILE_H

#include "output/mco.h"

/* An .h5 file by hdf5_result.h, every other as an .mco file. CML_E_INPUT; the caller clears *mco otherwise.
 */
CML_NODISCARD cml_status cml_result_file_read(const char *path, struct cml_mco *mco, struct cml_error *err);

#endif
