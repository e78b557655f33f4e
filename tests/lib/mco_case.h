/* Parts that the tests of result files share: a directory of their own, files in it, messages without its
 * name, and two files whose bytes are written out.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lib/case_files.h"

#define CASE_HEAD                                                                                            \
    "A1 \t# Version number of the file format.\n\n####\n# Data categories include: \n# InParm, RAT, \n"      \
    "# A_l, A_z, Rd_r, Rd_a, Tt_r, Tt_a, \n# A_rz, Rd_ra, Tt_ra \n####\n\n"
#define CASE_A_RZ                                                                                            \
    "# A[r][z]. [1/cm3]\n# A[0][0], [0][1],..[0][nz-1]\n# A[1][0], [1][1],..[1][nz-1]\n# ...\n"              \
    "# A[nr-1][0], [nr-1][1],..[nr-1][nz-1]\nA_rz\n"
#define CASE_RD_RA                                                                                           \
    "# Rd[r][angle]. [1/(cm2sr)].\n# Rd[0][0], [0][1],..[0][na-1]\n# Rd[1][0], [1][1],..[1][na-1]\n# ...\n"  \
    "# Rd[nr-1][0], [nr-1][1],..[nr-1][na-1]\nRd_ra\n"
#define CASE_TT_RA                                                                                           \
    "# Tt[r][angle]. [1/(cm2sr)].\n# Tt[0][0], [0][1],..[0][na-1]\n# Tt[1][0], [1][1],..[1][na-1]\n# ...\n"  \
    "# Tt[nr-1][0], [nr-1][1],..[nr-1][na-1]\nTt_ra\n"

/* A file with nz = 3, nr = 2, na = 1 and two layers: no grid ends with a full line. 75 lines. */
static const char case_open[] = CASE_HEAD
    "# User time:     7204 sec =     2.00 hr.   Simulation time of this run.\n\n"
    "InParm \t\t\t# Input parameters. cm is used.\n"
    "open.mco \tA\t\t# output file name, ASCII.\n"
    "1000000 \t\t\t# No. of photons\n"
    "0.01\t0.0025\t\t# dz, dr [cm]\n"
    "3\t2\t1\t# No. of dz, dr, da.\n\n"
    "2\t\t\t\t\t# Number of layers\n"
    "#n\tmua\tmus\tg\td\t# One line for each layer\n"
    "1\t\t\t\t\t# n for medium above\n"
    "1.37\t1\t100\t0.9\t0.1\t# layer 1\n"
    "1.4\t0\t0.333333\t-0.5\t1E+08\t# layer 2\n"
    "1.5\t\t\t\t\t# n for medium below\n\n"
    "RAT #Reflectance, absorption, transmission. \n"
    "0.0243729      \t#Specular reflectance [-]\n"
    "0.237544       \t#Diffuse reflectance [-]\n"
    "1E-05          \t#Absorbed fraction [-]\n"
    "0              \t#Transmittance [-]\n\n"
    "A_l #Absorption as a function of layer. [-]\n"
    "      0.2612\n"
    "       1E-05\n\n"
    "A_z #A[0], [1],..A[nz-1]. [1/cm]\n"
    "  2.7990E+00\n"
    "  2.8099E-12\n"
    "  0.0000E+00\n\n"
    "Rd_r #Rd[0], [1],..Rd[nr-1]. [1/cm2]\n"
    "  3.0924E+01\n"
    "  1.0071E+01\n\n"
    "Rd_a #Rd[0], [1],..Rd[na-1]. [sr-1]\n"
    "  3.4038E-02\n\n"
    "Tt_r #Tt[0], [1],..Tt[nr-1]. [1/cm2]\n"
    "  5.8942E-01\n"
    "  6.0085E-01\n\n"
    "Tt_a #Tt[0], [1],..Tt[na-1]. [sr-1]\n"
    "  1.3826E-02\n\n" CASE_A_RZ "  3.2948E+03   3.0386E+03   2.5033E+03   1.8514E+03   1.2758E+03 \n"
    "  8.5363E-99 \n" CASE_RD_RA "  5.5268E+02   3.6460E+02 \n" CASE_TT_RA "  1.7068E+02  -1.1574E+02 \n";

/* A file with nz = 1, nr = 5, na = 2 and one layer: every grid ends with a full line. */
static const char case_full[] =
    CASE_HEAD "# User time:        0 sec =     0.00 hr.   Simulation time of this run.\n\n"
              "InParm \t\t\t# Input parameters. cm is used.\n"
              "two words.mco \tA\t\t# output file name, ASCII.\n"
              "281474976710656 \t\t\t# No. of photons\n"
              "1E-05\t100\t\t# dz, dr [cm]\n"
              "1\t5\t2\t# No. of dz, dr, da.\n\n"
              "1\t\t\t\t\t# Number of layers\n"
              "#n\tmua\tmus\tg\td\t# One line for each layer\n"
              "1\t\t\t\t\t# n for medium above\n"
              "1.33333\t0.015\t707.7\t1\t100\t# layer 1\n"
              "1\t\t\t\t\t# n for medium below\n\n"
              "RAT #Reflectance, absorption, transmission. \n"
              "0.0200593      \t#Specular reflectance [-]\n"
              "0.924403       \t#Diffuse reflectance [-]\n"
              "0.055538       \t#Absorbed fraction [-]\n"
              "1.23457E-07    \t#Transmittance [-]\n\n"
              "A_l #Absorption as a function of layer. [-]\n"
              "     0.05554\n\n"
              "A_z #A[0], [1],..A[nz-1]. [1/cm]\n"
              "  5.5538E-02\n\n"
              "Rd_r #Rd[0], [1],..Rd[nr-1]. [1/cm2]\n"
              "  1.0000E+00\n  2.0000E+00\n  3.0000E+00\n  4.0000E+00\n  5.0000E+00\n\n"
              "Rd_a #Rd[0], [1],..Rd[na-1]. [sr-1]\n"
              "  6.0000E+00\n  7.0000E+00\n\n"
              "Tt_r #Tt[0], [1],..Tt[nr-1]. [1/cm2]\n"
              "  1.1000E+00\n  2.1000E+00\n  3.1000E+00\n  4.1000E+00\n  5.1000E+00\n\n"
              "Tt_a #Tt[0], [1],..Tt[na-1]. [sr-1]\n"
              "  6.1000E+00\n  7.1000E+00\n\n" CASE_A_RZ
              "  1.0000E-01   2.0000E-01   3.0000E-01   4.0000E-01   5.0000E-01 \n\n" CASE_RD_RA
              "  1.0000E-02   2.0000E-02   3.0000E-02   4.0000E-02   5.0000E-02 \n"
              "  6.0000E-02   7.0000E-02   8.0000E-02   9.0000E-02   9.9000E-02 \n\n" CASE_TT_RA
              "  1.0000E-03   2.0000E-03   3.0000E-03   4.0000E-03   5.0000E-03 \n"
              "  6.0000E-03   7.0000E-03   8.0000E-03   9.0000E-03   9.9000E-03 \n\n";

/* Returns a copy of `text` with every occurrence of `from` replaced. `from` must occur. The caller frees the
 * copy. */
static inline char *case_replace(const char *text, const char *from, const char *to)
{
    char *copy = calloc(1, 1 << 16);
    assert_non_null(copy);
    assert_non_null(strstr(text, from));
    char *end = copy;
    for (const char *hit; (hit = strstr(text, from)) != NULL; text = hit + strlen(from))
        end += sprintf(end, "%.*s%s", (int)(hit - text), text, to);
    strcpy(end, text);
    return copy;
}
