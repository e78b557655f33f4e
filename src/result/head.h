/* Reads the head of a finished result file, for --resume and notes: which run the file belongs to, and
 * whether it is whole. SPDX-License-Identifier: MIT */
#pragma once

#include "result/provenance.h"

#include <stdbool.h>
#include <stdint.h>

/* The head of a result file. */
struct cml_head {
    uint64_t photons;                /* 0: the file holds saved packets, no totals */
    char identity[CML_IDENTITY_SUM]; /* checksum of the run's identity; "": the file has none */
};

/* Reads the head of an .mco or .h5 file. Returns false if the path leads to no regular file, or to no whole
 * result. An .mco of this program is whole if
 *   - its last line is `# end` (with --classic: MCML's last section ends it), so that a cut file is refused;
 *   - MCML's sections have their names, and as many numbers as the sizes in the head say;
 *   - every line is text, and holds numbers, a comment or the name of a section.
 * A changed digit is not noticed, nor is a number missing from a section that MCML does not have. An .mco
 * without an identity is from another program or from an older version of this one; only its head is checked.
 * hdf5_head.h describes the checks of an .h5 file. */
bool cml_head_read(const char *path, struct cml_head *head);
