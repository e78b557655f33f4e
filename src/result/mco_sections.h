/* The layout of original MCML's .mco as data, shared by the writer and the reader of the head. Private to
 * mco.c and head.c. SPDX-License-Identifier: MIT */
#pragma once

#include "result/mco.h"

/* A section of an .mco: a profile (one number per line) or a grid (rows by columns, five numbers per
 * line). */
struct cml_mco_section {
    enum cml_quantity quantity;
    const char *before; /* comment lines in front of the key; "" for a profile */
    const char *after;  /* the rest of the key's line; "" for a grid */
};

/* All sections behind RAT, in the order of the file. */
#define CML_MCO_SECTIONS 9
extern const struct cml_mco_section cml_mco_sections[CML_MCO_SECTIONS];

/* Last line of this program's files. The line of the time, near the beginning, announces it. So files of
 * original MCML and of older versions, which end without this line, are not taken for cut off. */
#define CML_MCO_END "# end"
#define CML_MCO_HAS_END " Last line: " CML_MCO_END

/* Marks a file that cannot hold all results of its run; readers then look for the .h5 file. */
#define CML_MCO_BESIDE "# more of this run stands in the .h5 file beside this one, if the program has HDF5"

/* Stands on the line of the time, before the checksum of the run's identity. */
#define CML_MCO_IDENTITY " Identity: "
