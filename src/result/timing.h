/* The times of a run, and the numbers that are kept of it when its tallies are gone. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "tally/result.h"

/* The times of one rank, in seconds. */
struct cml_rank_report {
    uint64_t photons, ranges;
    double flying;  /* time in the engine */
    double asking;  /* time asking for ranges */
    double waiting; /* time waiting for other ranks, at synchronisations */
    double summing; /* time for sums and checkpoints, once all ranks were there */
    double elapsed;
    double processor; /* processor time of all threads, since the start or the resume */
};

/* The times of a run. */
struct cml_timing {
    double seconds; /* wall time of the photons' flight, with that before a resume */
    int threads, ranks;
    struct cml_rank_report *rank; /* [ranks] reports of all ranks, on rank 0 */
};

/* Returns the processor seconds of the photons' flight on all ranks: its cost on a machine that others use,
 * too. */
double cml_timing_processor(const struct cml_timing *timing);

/* Return the shares of all ranks' time spent waiting for other ranks, and on requests and
 * synchronisations. */
double cml_timing_idle(const struct cml_timing *timing);
double cml_timing_communication(const struct cml_timing *timing);

/* Kinds of numbers in the table of a sweep. If there are more layers and bodies, or detectors, than
 * CML_RECORD_MEDIA, none of them are recorded. */
enum cml_recorded {
    CML_RECORDED_TOTALS, /* totals; like all kinds except fluxes, shares of the launched weight */
    CML_RECORDED_FACE,   /* A_face, or nothing without faces and ports */
    CML_RECORDED_LAYERS, /* absorption of layers */
    CML_RECORDED_BODIES,
    CML_RECORDED_EXPECTED,  /* 0, 1 or 1 + layers numbers: Tt, then layers, as counted if not expected */
    CML_RECORDED_DETECTORS, /* detectors in the order of the scene */
    CML_RECORDED_FLUXES,    /* flux_body: CML_BODY_SIDES for each body, or 0 without facets */
    CML_NUM_RECORDED
};
#define CML_RECORD_MEDIA 32
#define CML_BODY_SIDES 4 /* number of sides of flux_body */
#define CML_RECORD_NUMBERS (CML_NUM_TOTALS + 1 + (3 + CML_BODY_SIDES) * CML_RECORD_MEDIA)

/* The record of a finished run. Zeroed, it is empty. */
struct cml_record {
    uint64_t photons, lost;
    int64_t count[CML_NUM_RECORDED];
    /* Numbers and errors, one kind behind the other. */
    double value[CML_RECORD_NUMBERS], error[CML_RECORD_NUMBERS];
    char *json; /* the run's object as --json prints it, with the line feed; owned */
};

/* Adds a number and its error. Kinds must come in their order. */
void cml_record_add(struct cml_record *record, enum cml_recorded kind, double value, double error);

/* Returns the place of number i of a kind among all numbers; -1 if the run has no such number. */
int cml_record_find(const struct cml_record *record, enum cml_recorded kind, int i);

/* True if the record has an allowed number of each kind. */
bool cml_record_is_sound(const struct cml_record *record);

void cml_record_clear(struct cml_record *record);
