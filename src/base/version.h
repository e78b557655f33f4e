/* Which program this is, for outputs and checkpoints. SPDX-License-Identifier: MIT */
#pragma once

const char *cml_version(void); /* "VERSION (git hash)"; without the hash where no repository was at hand */
const char *cml_version_parts(void); /* "MPI no, HDF5 yes, OpenCL yes": what may be left out of a build */
