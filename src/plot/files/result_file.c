/* SPDX-License-Identifier: MIT */
#include "plot/files/result_file.h"

#include "base/text.h"
#include "plot/files/hdf5_result.h"

cml_status cml_result_file_read(const char *path, struct cml_mco *mco, struct cml_error *err)
{
    return cml_file_ends_in(path, ".h5") ? cml_hdf5_read_result(path, mco, err)
                                         : cml_mco_read(path, mco, err);
}
