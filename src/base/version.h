/* Which program this is, for outputs and checkpoints. SPDX-License-Identifier: MIT */
#ifndef CML_VERSION_H
#define CML_VERSION_H

const char *cml_version(void); /* "0.1.0 (git hash)"; without the hash where no repository was at hand */

#endif
