/* What a run has found: the structure that writers write.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "result/provenance.h"
#include "result/quantity.h"
#include "tally/result.h"

/* Everything in it is owned. Arrays are row-major. Zeroed: nothing. */
struct cml_outcome {
    char *output;     /* file name as in the .mci */
    double user_time; /* s */
    uint64_t photons;
    double dz, dr; /* cm */
    int nz, nr, na;
    double time_end; /* ps; what is later is in no gate */
    int num_gates;   /* 0: nothing is known by time */
    int nt, np;      /* of directions; 0: nothing is known by them */
    int num_detectors;
    char **detector;      /* [num_detectors] their names */
    char *detector_names; /* all of these, parted by blanks; NULL: none */
    int num_layers, num_bodies;
    bool backed; /* of what is filled from sums: A_backing is among the totals */
    double n_above, n_below;
    double *value[CML_NUM_QUANTITIES]; /* [cml_outcome_size] as written, i.e. scaled; NULL: not there */
    double *error[CML_NUM_QUANTITIES]; /* standard errors of those; NULL: not known */

    char *program; /* that has written it: "1.0 (abc)"; NULL: another than ours, of which nothing below is
                      known */
    struct cml_provenance provenance;
    char identity[CML_IDENTITY_SUM]; /* of its run; "": not known */
    struct cml_lost_list lost;
    char lost_indices[24 * CML_LOST_LISTED]; /* the same numbers as a text, parted by blanks; "": none */
    /* The scene in words, each line ended by a line feed; "" or NULL: none. `scene`: of its input without the
     * lines for name and photons, which only .h5 files have. */
    char *settings, *beam, *phases, *detectors, *shapes, *scene;
    bool beside; /* the run has results, or shapes, that only its .h5 file holds */
};

/* Bins along an axis of a quantity. */
int cml_outcome_bins(const struct cml_outcome *outcome, enum cml_axis_kind axis);

/* Numbers of a quantity. */
size_t cml_outcome_size(const struct cml_outcome *outcome, enum cml_quantity quantity);

/* What files have of a quantity by itself: all of it, or the numbers of one detector. How many of these there
 * are, and numbers in each. */
int cml_outcome_parts(const struct cml_outcome *outcome, enum cml_quantity quantity);
size_t cml_outcome_part_size(const struct cml_outcome *outcome, enum cml_quantity quantity);

/* The name of a part in files: that of the quantity, or detector_NAME and what follows `detector` in it. */
#define CML_OUTCOME_KEY 64
void cml_outcome_key(const struct cml_outcome *outcome, enum cml_quantity quantity, int part,
                     char key[CML_OUTCOME_KEY]);

/* Makes room for values, or errors, all 0, where there is none yet. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_outcome_add(struct cml_outcome *outcome, enum cml_quantity quantity, bool errors,
                                         struct cml_error *err);

/* Totals, the numbers of layers and all arrays of an .mco of original MCML, for the sizes that are set. On
 * failure no array is left. */
CML_NODISCARD cml_status cml_outcome_allocate(struct cml_outcome *outcome, struct cml_error *err);

void cml_outcome_clear(struct cml_outcome *outcome);

/* A number of a layer, from 0, in the order of an .mci: n mua mus g d. */
double *cml_outcome_layer(const struct cml_outcome *outcome, int layer, int number);

/* Fills in all that comes of sums alone; what was not tallied stays away, but for A_z and A_rz, which are 0.
 * The sizes are those of the sums' grid. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_outcome_take(struct cml_outcome *outcome, const struct cml_result *sums,
                                          struct cml_error *err);
