/* What --resume and notes ask of a finished file: of which run the file is, and whether the file is whole.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "result/provenance.h"

#include <stdbool.h>
#include <stdint.h>

struct cml_head {
    uint64_t photons;                /* 0: the file holds saved packets, no totals */
    char identity[CML_IDENTITY_SUM]; /* "": the file has none */
};

/* Reads the head of an .mco or .h5 file. false: the path leads to no regular file, or to no whole result.
 * An .mco of ours is whole if
 *   - the line `# end` stands at its end (in a file of --classic, MCML's last section), so that a cut file is
 * refused;
 *   - MCML's sections have their names, and as many numbers as the sizes in the head say;
 *   - every line holds numbers, a comment or the name of a section, and nothing but text.
 * A changed digit, and a number that is missing from a section of ours, are not noticed. An .mco without an
 * identity is of another program, or of an older version of ours; only its head is looked at.
 * hdf5_head.h says what of an .h5 file is noticed. */
bool cml_head_read(const char *path, struct cml_head *head);
