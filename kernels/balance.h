/* Names of the sums over packets: terms of the weight balance, counts and totals; and the batches of photons.
 * In files and messages for users the terms are called `books`, and the amount by which they do not balance
 * is called `residue`.
 * SPDX-License-Identifier: MIT */
#pragma once

/* Number of bits by which a weight is shortened before it is squared: weights are rounded to 2^-16 of a
 * packet, so that the squares of 2^30 packets fit into 64 bits. Squares serve arrays with too many cells
 * for sums by group. Such an array takes its standard error from the sum of squared weights, because a
 * packet escapes only once. With lattice sampling this error is too large, never too small. */
#define CML_SQUARE_SHIFT 15

/* Layout of an array to whose cells a packet adds at most once. With sums by group, the cells of two
 * neighbouring groups lie `step` apart. With step 0 there is one cell for all groups, and its sum of squares
 * lies `squares` behind it. */
struct cml_once {
    unsigned long step, squares; /* 64 bits in C and OpenCL C */
};

/* The sum of a packet's visits to one medium (P13, P18). */
struct cml_stay {
    double length;   /* cm */
    double momentum; /* sum of 1 - cosine of its scatterings */
    unsigned interactions;
};

/* The photons of a run are dealt in turn to 64 batches: photon i is point i / 64 of batch i mod 64. This
 * holds for any number of photons, so a longer run has all packets of a shorter one, in the same batches.
 * Standard errors come from the spread of the batches. */
#define CML_LOG2_BATCHES 6
#define CML_NUM_BATCHES (1 << CML_LOG2_BATCHES)

/* Lowest bit of the beam's number in a photon's index. Each of several beams has photons of its own, so that
 * it has all points of the lattice. The bits below hold the photon's number in its beam, from 0. */
#define CML_SOURCE_SHIFT 48

/* Terms of the weight balance (P10). Exactly: launched + gained = specular + reflected + transmitted +
 * absorbed + roulette + trapped + lost + backing + face. */
enum cml_balance_term {
    CML_BALANCE_LAUNCHED,
    CML_BALANCE_GAINED, /* by packets that survived roulette */
    CML_BALANCE_SPECULAR,
    CML_BALANCE_REFLECTED,
    CML_BALANCE_TRANSMITTED,
    CML_BALANCE_ABSORBED,
    CML_BALANCE_ROULETTE, /* lost by packets that did not survive roulette */
    CML_BALANCE_TRAPPED,
    CML_BALANCE_LOST,
    /* Parts of the terms above, which are not in the balance. Only a result fills them; in a tally their
     * cells stay 0. */
    /* Parts of reflected, transmitted and absorbed that were scored in the last radial bin although they lie
     * beyond it. */
    CML_BALANCE_OVERFLOW_R,
    CML_BALANCE_OVERFLOW_Z, /* part of absorbed that lay below the last depth bin and was scored in it */
    CML_BALANCE_ABOVE,      /* part of absorbed that lay above z = 0 and was scored in the first depth bin */
    CML_BALANCE_BACKING,    /* kept by the backing; a term of the balance */
    CML_BALANCE_FACE,       /* kept by faces, or stopped by what lies on boundary 0; a term of the balance */
    CML_NUM_BALANCE_TERMS
};

enum cml_count {
    CML_COUNT_PHOTONS,
    CML_COUNT_INTERACTIONS,
    CML_COUNT_BOUNDARY_EVENTS,
    /* Searches for a crossing on curved surfaces: a figure of speed, not a result. */
    CML_COUNT_QUERIES,
    CML_COUNT_SHADING_OVERRULED, /* boundary events that the facet decided against the shading normal */
    CML_COUNT_TRAPPED,
    CML_COUNT_LOST_NO_SURFACE,
    CML_COUNT_LOST_NAN,
    CML_COUNT_LOST_STUCK,
    CML_COUNT_LOST_LEAKED,
    CML_COUNT_LOST_TOO_FAR,
    CML_COUNT_LOST_ROUGH,
    CML_COUNT_BRANCHES, /* P19: parts that were split off packets */
    CML_COUNT_UNSPLIT,  /* packets that stayed whole because the stack of branches was full */
    CML_COUNT_CLIPPED,  /* packets that would have split into more than CML_MOST_PARTS parts */
    /* Packets that would have split into more parts than was left of their budget of CML_MOST_OF_FAMILY
     * branches (windows.h). */
    CML_COUNT_SPENT,
    CML_NUM_COUNTS
};

/* Totals with standard errors, in their order in all arrays: Rsp, Rd, A, Tt, A_backing if there is a backing,
 * and A_face if there are faces or ports. */
enum cml_total {
    CML_TOTAL_SPECULAR,
    CML_TOTAL_REFLECTED,
    CML_TOTAL_ABSORBED,
    CML_TOTAL_TRANSMITTED,
    CML_TOTAL_BACKING,
    CML_TOTAL_FACE,
    CML_NUM_TOTALS
};
