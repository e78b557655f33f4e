/* The layout of an .mco file as data: what its writer and its reader share. Private to mco*.c.
 * SPDX-License-Identifier: MIT */
#ifndef CML_MCO_SECTIONS_H
#define CML_MCO_SECTIONS_H

#include "output/mco.h"

#include <stdbool.h>
#include <stddef.h>

/* A profile (one number per line) or a grid (rows by columns, five numbers per line). */
struct cml_mco_section {
    const char *before; /* comment lines in front of the key, "" for a profile */
    const char *key;
    const char *after; /* the rest of the key's line, "" for a grid */
    size_t values;     /* offset of the array in struct cml_mco */
    size_t rows;       /* offset of the number of rows */
    size_t columns;    /* offset of the number of columns; 0 for a profile */
    bool general;      /* %G instead of %E */
};

/* All sections behind RAT, in the order of the file. */
#define CML_MCO_SECTIONS 9
extern const struct cml_mco_section cml_mco_sections[CML_MCO_SECTIONS];

/* Numbers on a full line of a grid. */
#define CML_MCO_PER_LINE 5

int cml_mco_columns(const struct cml_mco *mco, const struct cml_mco_section *section); /* 0 for a profile */
size_t cml_mco_cells(const struct cml_mco *mco, const struct cml_mco_section *section);
double *cml_mco_values(const struct cml_mco *mco, const struct cml_mco_section *section);

#endif
