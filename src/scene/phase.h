/* Phase functions beside Henyey and Greenstein's: how much light is scattered into which cosine c of the
 * angle of deflection. p(c) is the density of c, 2 pi times that per solid angle, and integrates to 1 over
 * -1..1. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* With HG(g) for Henyey and Greenstein's p(c) = (1 - g^2) / 2 / (1 + g^2 - 2 g c)^(3/2):
 *   hg2       w HG(g1) + (1 - w) HG(g2)
 *   mhg       w HG(g) + (1 - w) 3 c^2 / 2 [Bevilacqua & Depeursinge, JOSA A 16, 2935 (1999)]
 *   gk        2 a g (1 - g^2)^(2 a) / (((1 + g)^(2 a) - (1 - g)^(2 a)) (1 + g^2 - 2 g c)^(a + 1))
 *             [Reynolds & McCormick, JOSA 70, 1206 (1980)], and its limits at a = 0 and g = 0
 *   rayleigh  3 (1 + c^2) / 8
 *   table     linear in c between rows */
enum cml_phase_kind { CML_PHASE_HG2, CML_PHASE_MHG, CML_PHASE_GK, CML_PHASE_RAYLEIGH, CML_PHASE_TABLE };
#define CML_PHASE_KINDS 5
#define CML_PHASE_NUMBERS 3  /* at most */
#define CML_MOST_PHASES 1000 /* of a scene; media with equal functions share one */

struct cml_phase {
    enum cml_phase_kind kind;
    double number[CML_PHASE_NUMBERS]; /* as in the line: g1 g2 w, g w, g a; |g| <= 0.9999, 0 <= w <= 1,
                                       * a > -1/2 */
    /* CML_PHASE_TABLE: rows from the forward direction on, */
    int rows;
    double *deflection;     /* [rows] 1 - c, rising from 0 to 2 */
    double *density;        /* [rows] p(c), scaled so that it integrates to 1 */
    double *below;          /* [rows] the share that is scattered by less than the row's */
    uint32_t checksum;      /* CRC-32 of deflection and density */
    char *file;             /* as the line names it, beside the .mci */
    int *users;             /* functions of several scenes that share arrays and file (base/shared.h) */
    int line;               /* of the .mci, the first that names it */
    int index;              /* which of the scene's this is, from 0 */
    struct cml_phase *next; /* of the scene */
};

/* "hg2" ... "table". */
const char *cml_phase_name(enum cml_phase_kind kind);

/* The names of its numbers, then NULL. */
const char *const *cml_phase_numbers(enum cml_phase_kind kind);

/* Makes a table ready, whose deflections and densities the caller has filled in, in any scale: makes `below`,
 * which is [rows] already, the scale and the checksum. False when all densities are 0 or the sum overflows.
 * */
bool cml_phase_scale_table(struct cml_phase *phase);

/* Share of the light that is scattered with 1 - c < deflection, 0 <= deflection <= 2. Nothing cancels near
 * the forward direction. */
double cml_phase_below(const struct cml_phase *phase, double deflection);

/* The density p(1 - deflection) of a phase function, which integrates to 1 over deflections 0 to 2. */
double cml_phase_density(const struct cml_phase *phase, double deflection);

/* The mean cosine of a phase function. Error < 1e-9. */
double cml_phase_mean(const struct cml_phase *phase);

/* Whether light is scattered by the same function. */
bool cml_phase_equal(const struct cml_phase *a, const struct cml_phase *b);

/* The words of its line; a table as "table of 181 rows". sums: with the checksum that tells tables apart. The
 * file is left out. */
void cml_phase_print(FILE *stream, const struct cml_phase *phase, bool sums);

/* Frees the phase function `first` and all that follow it. */
void cml_phases_free(struct cml_phase *first);
