/* The names of what is summed over packets.
 * SPDX-License-Identifier: MIT */
#ifndef CML_BOOKS_H
#define CML_BOOKS_H

/* launched + gained = specular + reflected + transmitted + absorbed + roulette + trapped + lost, exactly
 * (P10). */
enum cml_book {
    CML_BOOK_LAUNCHED,
    CML_BOOK_GAINED, /* by packets that survived roulette */
    CML_BOOK_SPECULAR,
    CML_BOOK_REFLECTED,
    CML_BOOK_TRANSMITTED,
    CML_BOOK_ABSORBED,
    CML_BOOK_ROULETTE, /* lost by packets that did not survive it */
    CML_BOOK_TRAPPED,
    CML_BOOK_LOST,
    /* parts of the above, not in the balance; a result's only, a tally has cells for them */
    CML_BOOK_OVERFLOW_R, /* of reflected, transmitted and absorbed: scored in the last radial bin from beyond
                            it */
    CML_BOOK_OVERFLOW_Z, /* of absorbed: in the last depth bin from below it */
    CML_BOOK_ABOVE,      /* of absorbed: in the first depth bin from z < 0 */
    CML_NUM_BOOKS
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
    CML_NUM_COUNTS
};

/* Totals whose squares per packet are summed for their standard errors. */
enum cml_total {
    CML_TOTAL_SPECULAR,
    CML_TOTAL_REFLECTED,
    CML_TOTAL_TRANSMITTED,
    CML_TOTAL_ABSORBED,
    CML_NUM_TOTALS
};

#endif
