/* The layout of original MCML's .mco as data: what its writer and its reader share. Private to mco*.c.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "result/mco.h"

/* A profile (one number per line) or a grid (rows by columns, five numbers per line). */
struct cml_mco_section {
    enum cml_quantity quantity;
    const char *before; /* comment lines in front of the key, "" for a profile */
    const char *after;  /* the rest of the key's line, "" for a grid */
};

/* All sections behind RAT, in the order of the file. */
#define CML_MCO_SECTIONS 9
extern const struct cml_mco_section cml_mco_sections[CML_MCO_SECTIONS];

/* Columns of a grid; 0 for a profile. */
static inline int cml_mco_columns(const struct cml_outcome *o, const struct cml_mco_section *section)
{
    return cml_outcome_bins(o, cml_quantities[section->quantity].axis[1]);
}

/* Numbers on a full line of a grid. */
#define CML_MCO_PER_LINE 5

/* Our files end with this line, and say so near their beginning, behind the time: so those of original MCML
 * and of our older versions, which end without one, are not taken for cut off. */
#define CML_MCO_END "# end"
#define CML_MCO_HAS_END " Last line: " CML_MCO_END

/* Stands in a file that has no place for all of its run; readers look for the .h5 then. */
#define CML_MCO_BESIDE "# more of this run stands in the .h5 file beside this one, if the program has HDF5"

/* Reads what stands behind the grids: comments and sections of ours. `has_end`: the file says so. CML_E_INPUT
 * only where memory runs out. */
CML_NODISCARD cml_status cml_mco_read_ours(const char *text, const char *path, bool has_end,
                                           struct cml_outcome *outcome, struct cml_error *err);
