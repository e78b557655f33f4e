/* The program's version, for outputs and checkpoints. SPDX-License-Identifier: MIT */
#pragma once

const char *cml_version(void);       /* returns "0.1.0 (git hash)"; no hash if built outside a repository */
const char *cml_version_parts(void); /* returns the optional parts of this build: "MPI no, HDF5 yes, OpenCL
                                        yes" */
