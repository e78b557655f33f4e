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

/* Numbers of a run that the table of a sweep has, kind by kind. Where there are more layers and bodies, or
 * detectors, than CML_RECORD_MEDIA, there are none of them. */
enum cml_recorded {
    CML_RECORDED_TOTALS, /* shares of the launched weight, as all of these but fluxes */
    CML_RECORDED_LAYERS, /* what they absorb */
    CML_RECORDED_BODIES,
    CML_RECORDED_EXPECTED,  /* 0, 1 or 1 + layers: Tt, then layers, those that are not expected as counted */
    CML_RECORDED_DETECTORS, /* in the order of the scene's */
    CML_RECORDED_FLUXES,    /* flux_body: CML_BODY_SIDES for each body, or 0 without facets */
    CML_NUM_RECORDED
};
#define CML_RECORD_MEDIA 32
#define CML_BODY_SIDES 4 /* of flux_body */
#define CML_RECORD_NUMBERS (CML_NUM_TOTALS + 1 + (3 + CML_BODY_SIDES) * CML_RECORD_MEDIA)

/* What is left to be said of a finished run. Zeroed: nothing. */
struct cml_record {
    uint64_t photons, lost;
    int64_t count[CML_NUM_RECORDED];
    double value[CML_RECORD_NUMBERS], error[CML_RECORD_NUMBERS]; /* one kind behind the other */
    char *json; /* its object, as --json prints it, with the line feed; owned */
};

/* Adds a number and its error; kinds in their order. */
void cml_record_add(struct cml_record *record, enum cml_recorded kind, double value, double error);

/* Where number i of a kind stands among all; -1: the run has no such number. */
int cml_record_find(const struct cml_record *record, enum cml_recorded kind, int i);

/* Whether there are as many of each kind as there may be. */
bool cml_record_is_sound(const struct cml_record *record);

void cml_record_clear(struct cml_record *record);
