/* How a run spent its time, and what is left to be said of it when its tallies are gone.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "tally/result.h"

/* How one rank spent its time, seconds. */
struct cml_rank_report {
    uint64_t photons, ranges;
    double flying;  /* in the engine */
    double asking;  /* for ranges */
    double waiting; /* for other ranks, at synchronisations */
    double summing; /* sums and checkpoints, once all were there */
    double elapsed;
    double processor; /* of all threads, since the start or the resume */
};

struct cml_timing {
    double seconds; /* wall time of the photons' flight, that before a resume included */
    int threads, ranks;
    struct cml_rank_report *rank; /* [ranks] on rank 0 */
};

/* Processor seconds of the photons' flight on all ranks: what it costs on a machine that others use too. */
double cml_timing_processor(const struct cml_timing *timing);

/* Shares of all ranks' time that went into waiting for other ranks, and into requests and synchronisations.
 */
double cml_timing_idle(const struct cml_timing *timing);
double cml_timing_communication(const struct cml_timing *timing);

/* So many layers and bodies have columns in the table of a sweep. */
#define CML_RECORD_MEDIA 32
#define CML_BODY_SIDES 4 /* of flux_body */

/* What is left to be said of a finished run. Zeroed: nothing. */
struct cml_record {
    uint64_t photons, lost;
    double value[CML_NUM_TOTALS], error[CML_NUM_TOTALS]; /* totals, shares of the launched weight */
    int num_layers, num_bodies; /* of these the following; 0 where they are too many */
    double absorbed[CML_RECORD_MEDIA], absorbed_error[CML_RECORD_MEDIA]; /* layers, then bodies */
    int64_t num_expected; /* of the following: 0, 1, or 1 + num_layers; the others are as counted */
    double expected[1 + CML_RECORD_MEDIA], expected_error[1 + CML_RECORD_MEDIA]; /* Tt, then layers */
    int64_t
        num_detectors; /* of the following, in the order of the scene's; 0: of none, or of more than that */
    double detected[CML_RECORD_MEDIA], detected_error[CML_RECORD_MEDIA];
    int64_t num_fluxes; /* of the following, flux_body: CML_BODY_SIDES for each body, or 0 without facets */
    double flux[CML_BODY_SIDES * CML_RECORD_MEDIA], flux_error[CML_BODY_SIDES * CML_RECORD_MEDIA];
    char *json; /* its object, as --json prints it, with the line feed; owned */
};

void cml_record_clear(struct cml_record *record);
