/* Original MCML's result file: the numbers, the writer and the reader.
 * Lines 1 to the end of Tt_ra are byte for byte what MCML 1.2.2 writes; what is ours follows as `extra` text,
 * whose lines begin with '#' or with a keyword that no section of MCML begins with. Knows nothing of tallies
 * or engines. Layout: MCML manual (Wang and Jacques 1992), section 9.3, and observed on version 1.2.2;
 * scaling.h says how its numbers come about.
 * SPDX-License-Identifier: MIT */
#ifndef CML_MCO_H
#define CML_MCO_H

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* One result. Arrays are owned, row-major, r outer; values as written, i.e. already scaled. */
struct cml_mco {
    char *output;     /* file name as in the .mci */
    double user_time; /* s */
    uint64_t photons;
    double dz, dr; /* cm */
    int nz, nr, na;
    int num_layers; /* L */
    double n_above, n_below;
    double (*layer)[5];    /* [L] n mua mus g d */
    double Rsp, Rd, A, Tt; /* [-] */
    double *A_l;           /* [L] [-] */
    double *A_z;           /* [nz] 1/cm */
    double *Rd_r, *Tt_r;   /* [nr] 1/cm2 */
    double *Rd_a, *Tt_a;   /* [na] 1/sr */
    double *A_rz;          /* [nr][nz] 1/cm3 */
    double *Rd_ra, *Tt_ra; /* [nr][na] 1/(cm2 sr) */
    bool curved;           /* the file's copy of its input has boundaries that are no planes */
    char *extra; /* everything behind the Tt_ra block, "" when there is nothing; ends in a line feed */
};

/* Allocates the arrays (zeroed) for the sizes and layer count already set in *mco, all above 0; extra becomes
 * NULL. On failure no array is left. */
CML_NODISCARD cml_status cml_mco_allocate(struct cml_mco *mco, struct cml_error *err);

void cml_mco_clear(struct cml_mco *mco);

/* Writes to `path` atomically (atomic_file.h). CML_E_IO on failure. The time is rounded to whole seconds, as
 * in the original. */
CML_NODISCARD cml_status cml_mco_write(const char *path, const struct cml_mco *mco, struct cml_error *err);

/* Reads a file written by us, by original MCML 1.x, by MSVC builds of it (3-digit exponents), by gpumcml,
 * CUDAMCML or the 2019 clustermcml (`InParam` with a verbatim copy of the .mci, b lines included).
 * CML_E_INPUT names file, line and what was expected. On failure *mco is cleared. Writing what was read from
 * our own file gives the same bytes. */
CML_NODISCARD cml_status cml_mco_read(const char *path, struct cml_mco *mco, struct cml_error *err);

/* In a comment of `extra` of a run without re-entry, and of what such runs were merged to. */
#define CML_MCO_FIRST_EXIT "packets are scored at their first exit"

/* Values of one of our own sections in `extra`: a line that begins with `key` and a blank, then numbers, one
 * per line, of errors NaN, too. Returns how many were found, at most `capacity`; 0 when there is no such
 * section. */
int cml_mco_extra(const struct cml_mco *mco, const char *key, double *values, int capacity);

#endif
