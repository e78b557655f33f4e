/* A sweep under way, and the scenes of its rows. Private to sweep.c and sweep_flights.c.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "cli/run/before.h"
#include "cli/run/outputs.h"
#include "cli/run/pending.h"
#include "cli/run/sweep_rows.h"
#include "input/sweep/sweep_table.h"
#include "surface/surface.h"

/* What all rows share. */
struct cml_sweep_run {
    const struct cml_options *options;
    const struct cml_scene_list *base;
    struct cml_inputs *inputs;
    struct cml_sweep_table table;
    bool unmarked[CML_MOST_SETTINGS]; /* columns that are labels without quotation marks */
    int seed_column;                  /* -1: the rows have the seed of the options */
    int num_groups, *group;           /* with --reweight: flights, and the one of each row; else NULL */
    char *identity;                   /* lines of the identity: the files but for the table */
    struct cml_surface_set surfaces;  /* of the scene without rows: their trees are built once */
    int num_anew; /* with --resume: rows whose results have no checkpoint, and are flown anew */
    char replaced[CML_REPLACED]; /* the first of them, in words */
    struct cml_outputs outputs;  /* rank 0's */
    struct cml_sweep_rows rows;
    struct cml_pending pending; /* of this rank */
    int digits;                 /* of a row's number in names */
};

/* "NAME-0001.mco" of row 0; of format B "NAME-0001.h5", since the ending of a name from outside is a format.
 * *name is the caller's to free. */
CML_NODISCARD cml_status cml_sweep_row_output(const struct cml_sweep_run *sweep, int row, char **name,
                                              struct cml_error *err);

/* Gives the scene of a row a name of its own for saved packets, "NAME-0001", where there are any: *name is
 * replaced, and the caller's to free. */
CML_NODISCARD cml_status cml_sweep_name_saved(const struct cml_sweep_run *sweep, int row, char **name,
                                              struct cml_error *err);

/* The settings of a row for its scene: all columns but the seed and labels. */
CML_NODISCARD cml_status cml_sweep_row_settings(const struct cml_sweep_run *sweep, int row,
                                                struct cml_settings *settings, struct cml_error *err);
CML_NODISCARD cml_status cml_sweep_row_seed(const struct cml_sweep_run *sweep, int row, uint64_t *seed,
                                            struct cml_error *err);

/* The scene of a row, and the same with other settings, the caller's to clear. */
CML_NODISCARD cml_status cml_sweep_read_row(const struct cml_sweep_run *sweep, int row,
                                            struct cml_scene *scene, struct cml_error *err);
CML_NODISCARD cml_status cml_sweep_read(const struct cml_sweep_run *sweep, int row,
                                        const struct cml_settings *settings, struct cml_scene *scene,
                                        struct cml_error *err);

/* Says of which row, and of which values, it is what was said of its scene. Hands the status on. */
CML_NODISCARD cml_status cml_sweep_name_row(const struct cml_sweep_run *sweep, int row, cml_status status,
                                            struct cml_error *err);

/* One line for people. */
void cml_sweep_print_row(const struct cml_sweep_run *sweep, int row, const struct cml_record *record);

/* On all ranks: that a result is not safe counts more than that a row's weight does not balance. */
CML_NODISCARD cml_status cml_sweep_add_safety(cml_status status, cml_status safe, struct cml_error *why,
                                              struct cml_error *err);
