/* The outcome of a run: all its results, scaled, as writers of files need them. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "base/status.h"
#include "result/provenance.h"
#include "result/quantity.h"
#include "tally/result.h"

/* The results of a run. It owns all its members; arrays are row-major. Zeroed, it is empty. */
struct cml_outcome {
    char *output;     /* output file name as the .mci has it */
    double user_time; /* processor time, s */
    uint64_t photons;
    double dz, dr; /* grid spacing, cm */
    int nz, nr, na;
    double time_end; /* end of the last gate, ps; later light is in no gate */
    int num_gates;   /* number of gates; 0: nothing is known by time */
    int nt, np;      /* number of bins of directions; 0: nothing is known by direction */
    int num_detectors;
    char **detector;      /* [num_detectors] names of the detectors */
    char *detector_names; /* all detector names, separated by blanks; NULL: none */
    int num_layers, num_bodies;
    bool backed; /* the scene has a backing: A_backing is among the totals */
    bool faced;  /* the scene has faces or ports: A_face is among the totals */
    double n_above, n_below;
    /* [cml_outcome_size] values as written, i.e. scaled; NULL: not known */
    double *value[CML_NUM_QUANTITIES];
    double *error[CML_NUM_QUANTITIES]; /* [cml_outcome_size] standard errors of the values; NULL: not known */

    /* Version of this program that wrote the results, "1.0 (abc)". NULL: another program, and no member below
     * is known. */
    char *program;
    struct cml_provenance provenance;
    char identity[CML_IDENTITY_SUM]; /* checksum of the run's identity; "": not known */
    struct cml_lost_list lost;
    /* Indices of lost packets as a text, separated by blanks; "": none. */
    char lost_indices[24 * CML_LOST_LISTED];
    /* The scene in words, each line ended by a line feed; "" or NULL: none. */
    char *settings, *beam, *phases, *detectors, *shapes, *top;
    bool beside; /* some results, or shapes, of the run stand only in its .h5 file */
};

/* Returns the number of bins along an axis. */
int cml_outcome_bins(const struct cml_outcome *outcome, enum cml_axis_kind axis);

/* Returns the number of values of a quantity. */
size_t cml_outcome_size(const struct cml_outcome *outcome, enum cml_quantity quantity);

/* Return the number of parts of a quantity that files store separately, and the number of values of each
 * part. A quantity of detectors has one part per detector, all others have one. */
int cml_outcome_parts(const struct cml_outcome *outcome, enum cml_quantity quantity);
size_t cml_outcome_part_size(const struct cml_outcome *outcome, enum cml_quantity quantity);

/* Writes the name of a part in files: the name of the quantity, or for detectors detector_NAME with the
 * quantity's ending. CML_OUTCOME_KEY: size of the name in bytes. */
#define CML_OUTCOME_KEY 64
void cml_outcome_key(const struct cml_outcome *outcome, enum cml_quantity quantity, int part,
                     char key[CML_OUTCOME_KEY]);

/* Makes room for values, or errors, of a quantity if there is none yet, and sets them to 0. CML_E_INPUT when
 * memory runs out. */
CML_NODISCARD cml_status cml_outcome_add(struct cml_outcome *outcome, enum cml_quantity quantity, bool errors,
                                         struct cml_error *err);

/* Makes room for the totals, the numbers of layers, and all arrays of an original .mco. The sizes must be
 * set. On failure no array is left. */
CML_NODISCARD cml_status cml_outcome_allocate(struct cml_outcome *outcome, struct cml_error *err);

void cml_outcome_clear(struct cml_outcome *outcome);

/* Returns a number of a layer (layers from 0), in the order of an .mci: n mua mus g d. */
double *cml_outcome_layer(const struct cml_outcome *outcome, int layer, int number);

/* Fills in all quantities that can be computed from sums. Quantities that were not tallied stay unknown,
 * except A_z and A_rz, which become 0. The outcome's sizes must be those of the sums' grid. CML_E_INPUT when
 * memory runs out. */
CML_NODISCARD cml_status cml_outcome_take(struct cml_outcome *outcome, const struct cml_result *sums,
                                          struct cml_error *err);
