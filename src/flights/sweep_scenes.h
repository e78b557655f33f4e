/* A sweep in progress, and the scenes of its rows. Private to the files sweep*.c here.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "flights/before.h"
#include "flights/outputs.h"
#include "flights/pending.h"
#include "flights/sweep_rows.h"
#include "input/sweep/sweep_table.h"
#include "surface/surface.h"

/* State that all rows of a sweep share. */
struct cml_sweep_run {
    const struct cml_options *options;
    const struct cml_scene_list *base;
    struct cml_inputs *inputs;
    struct cml_sweep_table table;
    bool unmarked[CML_MOST_SETTINGS]; /* columns that are labels without quotation marks */
    int seed_column;                  /* column of the seed; -1: all rows have the seed of the options */
    /* with --reweight: number of flights, and the flight of each row; else 0, NULL */
    int num_groups, *group;
    /* lines about the input files in the identity of a run; the table has no line */
    char *identity;
    struct cml_surface_set surfaces; /* surfaces of the base scene, whose trees are built only once */
    int num_anew; /* with --resume: rows whose results have no checkpoint, and which are flown again */
    char replaced[CML_REPLACED]; /* description of the first result that is replaced */
    struct cml_outputs outputs;  /* claimed files of all rows, on rank 0 only */
    struct cml_sweep_rows rows;
    struct cml_pending pending; /* finished rows of this rank */
    int digits;                 /* digits of a row's number in names */
};

/* Returns in *name the output of a row: "NAME-0001.mco" for row 0; with format B "NAME-0001.h5", because the
 * ending of a name given to cml_mci_copy sets the format. The caller frees *name. */
CML_NODISCARD cml_status cml_sweep_row_output(const struct cml_sweep_run *sweep, int row, char **name,
                                              struct cml_error *err);

/* Gives the scene of a row its own name for saved packets, "NAME-0001", if packets are saved. Replaces *name;
 * the caller frees it. */
CML_NODISCARD cml_status cml_sweep_name_saved(const struct cml_sweep_run *sweep, int row, char **name,
                                              struct cml_error *err);

/* Returns the settings of a row for its scene: all columns except the seed and labels. */
CML_NODISCARD cml_status cml_sweep_row_settings(const struct cml_sweep_run *sweep, int row,
                                                struct cml_settings *settings, struct cml_error *err);
CML_NODISCARD cml_status cml_sweep_row_seed(const struct cml_sweep_run *sweep, int row, uint64_t *seed,
                                            struct cml_error *err);

/* Read the scene of a row. cml_sweep_read_row uses the settings of the row, cml_sweep_read the given ones.
 * The caller clears *scene. */
CML_NODISCARD cml_status cml_sweep_read_row(const struct cml_sweep_run *sweep, int row,
                                            struct cml_scene *scene, struct cml_error *err);
CML_NODISCARD cml_status cml_sweep_read(const struct cml_sweep_run *sweep, int row,
                                        const struct cml_settings *settings, struct cml_scene *scene,
                                        struct cml_error *err);

/* Adds the row's number and values to the message *err about its scene. Returns `status`. */
CML_NODISCARD cml_status cml_sweep_name_row(const struct cml_sweep_run *sweep, int row, cml_status status,
                                            struct cml_error *err);

/* Prints a row with its totals, in one line for people. */
void cml_sweep_print_row(const struct cml_sweep_run *sweep, int row, const struct cml_record *record);

/* Combines two statuses, on all ranks: a result that is not safe on the disk counts more than a row whose
 * weights do not balance. Returns the worse, with its message in *err. */
CML_NODISCARD cml_status cml_sweep_add_safety(cml_status status, cml_status safe, struct cml_error *why,
                                              struct cml_error *err);
