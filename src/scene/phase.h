/* Phase functions other than Henyey and Greenstein's: the density p(c) of the cosine c of the scattering
 * angle. p integrates to 1 over -1..1, so it is 2 pi times the density per solid angle.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* The kinds of phase functions. HG(g) is Henyey and Greenstein's
 * p(c) = (1 - g^2) / 2 / (1 + g^2 - 2 g c)^(3/2).
 *
 *   hg2       w HG(g1) + (1 - w) HG(g2)
 *   mhg       w HG(g) + (1 - w) 3 c^2 / 2 [Bevilacqua & Depeursinge, JOSA A 16, 2935 (1999)]
 *   gk        2 a g (1 - g^2)^(2 a) / (((1 + g)^(2 a) - (1 - g)^(2 a)) (1 + g^2 - 2 g c)^(a + 1))
 *             [Reynolds & McCormick, JOSA 70, 1206 (1980)], and its limits at a = 0 and g = 0
 *   rayleigh  3 (1 + c^2) / 8
 *   table     linear in c between rows */
enum cml_phase_kind { CML_PHASE_HG2, CML_PHASE_MHG, CML_PHASE_GK, CML_PHASE_RAYLEIGH, CML_PHASE_TABLE };
#define CML_PHASE_KINDS 5
#define CML_PHASE_NUMBERS 3 /* the largest number of parameters of a kind */
/* Limit of different phase functions in a scene; media with equal functions share one. */
#define CML_MOST_PHASES 1000

/* A phase function of a scene. Scenes keep them in a list. */
struct cml_phase {
    enum cml_phase_kind kind;
    /* Parameters in the order of the .mci line: g1 g2 w, or g w, or g a; |g| <= 0.9999, 0 <= w <= 1, a >
     * -1/2. */
    double number[CML_PHASE_NUMBERS];
    /* Members of CML_PHASE_TABLE. Rows begin at the forward direction. */
    int rows;
    double *deflection; /* [rows] deflection 1 - c, rising from 0 to 2 */
    double *density;    /* [rows] p(c), scaled so that it integrates to 1 */
    double *below;      /* [rows] share of the light that is deflected less than this row */
    uint32_t checksum;  /* CRC-32 of deflection and density */
    char *file;         /* the table's file as the line names it, relative to the .mci */
    /* Reference count: phase functions of several scenes share arrays and file (base/shared.h). */
    int *users;
    int line;               /* line number in the .mci of the first line that names the function */
    int index;              /* number of the function in its scene, from 0 */
    struct cml_phase *next; /* next phase function of the same scene */
};

/* Returns the kind's word in the .mci: "hg2" ... "table". */
const char *cml_phase_name(enum cml_phase_kind kind);

/* Completes a table whose deflections and densities, in any scale, the caller has filled in. Scales the
 * densities, fills `below`, which must have room for all rows, and sets the checksum. Returns false if all
 * densities are 0 or their sum overflows. */
bool cml_phase_scale_table(struct cml_phase *phase);

/* Returns the share of the light that is scattered with 1 - c < deflection, 0 <= deflection <= 2. No digits
 * cancel near the forward direction. */
double cml_phase_below(const struct cml_phase *phase, double deflection);

/* Returns the density p(1 - deflection) of a phase function. It integrates to 1 over deflections 0 to 2. */
double cml_phase_density(const struct cml_phase *phase, double deflection);

/* Returns the mean cosine of a phase function, with an error below 1e-9. */
double cml_phase_mean(const struct cml_phase *phase);

/* True if both phase functions scatter light alike. */
bool cml_phase_equal(const struct cml_phase *a, const struct cml_phase *b);

/* Prints a phase function as its .mci line has it; a table as "table of 181 rows" without its file. sums:
 * also prints the checksum, which tells tables apart. */
void cml_phase_print(FILE *stream, const struct cml_phase *phase, bool sums);

/* Frees the phase function `first` and all that follow it in its list. */
void cml_phases_free(struct cml_phase *first);
