/* SPDX-License-Identifier: MIT */
#include "plot/files/result_file.h"

#include "plot/files/hdf5_result.h"

#include <string.h>
#include <strings.h>

bool cml_file_ends_in(const char *path, const char *extension)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot, extension) == 0;
}

cml_status cml_result_file_read(const char *path, struct cml_mco *mco, struct cml_error *err)
{
    return cml_file_ends_in(path, ".h5") ? cml_hdf5_read_result(path, mco, err)
                                         : cml_mco_read(path, mco, err);
}
