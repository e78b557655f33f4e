/* The names of what is summed over packets: the terms of the weight balance, counts, totals; and batches.
 * In files and messages for users the terms are called `books`, and by how much they do not balance
 * `residue`. SPDX-License-Identifier: MIT */
#pragma once

/* A packet escapes once. So the sum of squared weights gives a standard error that lattice sampling makes too
 * large, where an array has too many cells for sums of each group of packets. Weights are rounded to
 * 2^-16 of a packet before they are squared: 2^30 packets then fit into 64 bits. */
#define CML_SQUARE_SHIFT 15

/* An array to whose cells a packet adds at most once. A cell of one group of packets and that of the next lie
 * `step` apart. 0: there is one for all groups, and its sum of squares lies `squares` behind it. */
struct cml_once {
    unsigned long step, squares; /* 64 bits in C and OpenCL C */
};

/* All visits of a packet to one medium (P13, P18). */
struct cml_stay {
    double length;   /* cm */
    double momentum; /* sum of 1 - cosine of its scatterings */
    unsigned interactions;
};

/* The photons of a run are dealt out in turn to 64 batches: photon i is point i / 64 of batch i mod 64. How
 * many photons there are does not matter, so a longer run has all packets of a shorter one, in the same
 * batches. Standard errors come from the spread of the batches. */
#define CML_LOG2_BATCHES 6
#define CML_NUM_BATCHES (1 << CML_LOG2_BATCHES)

/* Each of several beams has photons of its own, so that it has all points of the lattice: their index is that
 * of the beam, from 0, above so many bits, and their number there below. */
#define CML_SOURCE_SHIFT 48

/* launched + gained = specular + reflected + transmitted + absorbed + roulette + trapped + lost + backing,
 * exactly (P10). */
enum cml_balance_term {
    CML_BALANCE_LAUNCHED,
    CML_BALANCE_GAINED, /* by packets that survived roulette */
    CML_BALANCE_SPECULAR,
    CML_BALANCE_REFLECTED,
    CML_BALANCE_TRANSMITTED,
    CML_BALANCE_ABSORBED,
    CML_BALANCE_ROULETTE, /* lost by packets that did not survive it */
    CML_BALANCE_TRAPPED,
    CML_BALANCE_LOST,
    /* parts of the above, not in the balance; a result's only, a tally has cells for them */
    CML_BALANCE_OVERFLOW_R, /* of reflected, transmitted and absorbed: scored in the last radial bin from
                            beyond it */
    CML_BALANCE_OVERFLOW_Z, /* of absorbed: in the last depth bin from below it */
    CML_BALANCE_ABOVE,      /* of absorbed: in the first depth bin from z < 0 */
    CML_BALANCE_BACKING,    /* kept by the backing; in the balance */
    CML_NUM_BALANCE_TERMS
};

enum cml_count {
    CML_COUNT_PHOTONS,
    CML_COUNT_INTERACTIONS,
    CML_COUNT_BOUNDARY_EVENTS,
    CML_COUNT_QUERIES,           /* curved surfaces asked for a crossing: a figure of speed, not a result */
    CML_COUNT_SHADING_OVERRULED, /* boundary events that the facet decided against the shading normal */
    CML_COUNT_TRAPPED,
    CML_COUNT_LOST_NO_SURFACE,
    CML_COUNT_LOST_NAN,
    CML_COUNT_LOST_STUCK,
    CML_COUNT_LOST_LEAKED,
    CML_COUNT_LOST_TOO_FAR,
    CML_COUNT_LOST_ROUGH,
    CML_COUNT_BRANCHES, /* P19: parts that packets left behind where they were split */
    CML_COUNT_UNSPLIT,  /* packets that were to be split, and were not, as no more could wait */
    CML_COUNT_CLIPPED,  /* those that were to have more than CML_MOST_PARTS parts */
    CML_COUNT_SPENT,    /* or more than were left of CML_MOST_OF_FAMILY */
    CML_NUM_COUNTS
};

/* Totals that have standard errors, in the order in which they stand everywhere: Rsp, Rd, A, Tt, and
 * A_backing where there is a backing. */
enum cml_total {
    CML_TOTAL_SPECULAR,
    CML_TOTAL_REFLECTED,
    CML_TOTAL_ABSORBED,
    CML_TOTAL_TRANSMITTED,
    CML_TOTAL_BACKING,
    CML_NUM_TOTALS
};
