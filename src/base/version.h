/* The program's version, for outputs and checkpoints. SPDX-License-Identifier: MIT */
#pragma once

/* Returns "VERSION (git hash)"; no hash if built outside a repository. */
const char *cml_version(void);

/* Returns the optional parts of this build: "MPI no, HDF5 yes, OpenCL yes". */
const char *cml_version_parts(void);
