/* The version strings, made by CMake. SPDX-License-Identifier: MIT */
#include "base/version.h"

const char *cml_version(void)
{
    return CML_GIT[0] ? CML_VERSION " (" CML_GIT ")" : CML_VERSION;
}

const char *cml_version_parts(void)
{
    return CML_PARTS;
}
