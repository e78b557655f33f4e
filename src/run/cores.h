/* The cores that this process may run on, as a launcher or a batch system bound it.
 * SPDX-License-Identifier: MIT */
#ifndef CML_CORES_H
#define CML_CORES_H

struct cml_cores {
    unsigned char bits[128]; /* one bit per core: masks of several processes can be joined by or */
};

/* All cores that threads of this process may run on, wherever OpenMP bound the calling one; empty when the
 * system does not tell. */
void cml_cores_mine(struct cml_cores *cores);

/* Number of cores in a mask. */
int cml_cores_count(const struct cml_cores *cores);

#endif
