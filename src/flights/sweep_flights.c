/* SPDX-License-Identifier: MIT */
#include "flights/sweep_flights.h"

#include "base/text.h"
#include "simulation/scenes.h"
#include "flights/one_run.h"
#include "input/sweep/sweep_groups.h"
#include "run/cluster/cluster.h"
#include "run/join.h"
#include "tally/row_cells.h"

#include <stdio.h>
#include <stdlib.h>

cml_status cml_sweep_check_options(const struct cml_options *options, struct cml_error *err)
{
    const struct {
        bool given;
        const char *name;
    } excluded[] = {{options->keep, "--keep or --more"},
                    {options->target_error > 0, "--target-error"},
                    {options->aim, "--aim"},
                    {!options->engine->reweights, "--engine opencl"}};
    if (!options->reweight) return CML_OK;
    if (!options->sweep) return cml_fail(err, CML_E_INPUT, "--reweight (expected --sweep beside it)");
    for (size_t i = 0; i < sizeof excluded / sizeof *excluded; i++)
        if (excluded[i].given)
            return cml_fail(err, CML_E_INPUT, "--reweight (expected no %s beside it)", excluded[i].name);
    return CML_OK;
}

cml_status cml_sweep_check_reweighted(const struct cml_scene *scene, struct cml_error *err)
{
    const char *has = scene->fluence.line > 0 ? "fluence"
                      : scene->map.nx > 0     ? "a map"
                      : scene->facets         ? "facets"
                                              : NULL;
    for (int k = 0; !has && k < scene->num_detectors; k++)
        if (scene->detectors[k].shape == CML_DETECTOR_MAP) has = "a detector map";
    if (!has) return CML_OK;
    return cml_fail(
        err, CML_E_INPUT,
        "--reweight: %.400s has %s, which rows cannot share (expected totals, profiles over r and angle, "
        "times, directions, detectors that are no maps, and absorption of layers and bodies)",
        scene->output, has);
}

/* The rows that share a flight. */
struct group {
    int count, *row;       /* numbers of the rows, rising */
    struct cml_scene *own; /* [count] scenes of the rows */
    /* The scene that is flown: each medium has the least absorption of all rows. */
    struct cml_scene flown;
    const struct cml_scene **scene; /* [count] pointers into `own` */
    struct cml_record *record;      /* [count] records of the rows */
    /* [media][count] mua of each row minus mua of the scene flown, 1/cm */
    double *more;
    char *identity;
};

/* Frees the rows that share one flight. `own`: scenes of the rows; `flown`: the scene that is flown for
 * all. */
static void clear_group(struct group *group)
{
    for (int i = 0; group->own && i < group->count; i++) cml_scene_clear(&group->own[i]);
    for (int i = 0; group->record && i < group->count; i++) cml_record_clear(&group->record[i]);
    cml_scene_clear(&group->flown);
    free(group->own);
    free(group->row);
    free(group->scene);
    free(group->record);
    free(group->more);
    free(group->identity);
}

/* Finds the rows of a group, and makes room for their scenes and records. */
static cml_status find_rows(const struct cml_sweep_run *sweep, int number, struct group *group,
                            struct cml_error *err)
{
    const size_t most = (size_t)sweep->table.num_rows;
    CML_TRY(cml_zeros(&group->row, most, sizeof *group->row, "the rows", err));
    CML_TRY(cml_zeros(&group->own, most, sizeof *group->own, "the rows", err));
    CML_TRY(cml_zeros(&group->scene, most, sizeof *group->scene, "the rows", err));
    CML_TRY(cml_zeros(&group->record, most, sizeof *group->record, "the rows", err));
    for (int row = 0; row < sweep->table.num_rows; row++)
        if (sweep->group[row] == number) group->row[group->count++] = row;
    return CML_OK;
}

/* Returns the cell with the least number among the rows of a group, in one column. */
static struct cml_setting least_cell(const struct cml_sweep_run *sweep, const struct group *group, int column)
{
    struct cml_setting least = cml_sweep_cell(&sweep->table, group->row[0], column);
    for (int i = 1; i < group->count; i++) {
        const struct cml_setting cell = cml_sweep_cell(&sweep->table, group->row[i], column);
        if (strtod(cell.value, NULL) < strtod(least.value, NULL)) least = cell;
    }
    return least;
}

/* Reads the scene that is flown for a group: each medium has its least absorption. */
static cml_status read_flown(const struct cml_sweep_run *sweep, struct group *group, struct cml_error *err)
{
    struct cml_settings settings;
    CML_TRY(cml_sweep_row_settings(sweep, group->row[0], &settings, err));
    for (int c = 0; c < sweep->table.num_columns; c++) {
        if (sweep->table.label[c] || !cml_sweep_is_absorption(sweep->table.name[c])) continue;
        const struct cml_setting least = least_cell(sweep, group, c);
        for (int s = 0; s < settings.count; s++)
            if (strcmp(settings.item[s].name, least.name) == 0) settings.item[s].value = least.value;
    }
    return cml_sweep_read(sweep, group->row[0], &settings, &group->flown, err);
}

/* Reads the scenes of all rows of a group, and how much more they absorb than the scene flown. */
static cml_status read_group(const struct cml_sweep_run *sweep, struct group *group, struct cml_error *err)
{
    CML_TRY(read_flown(sweep, group, err));
    const struct cml_scene *flown = &group->flown;
    const size_t media = (size_t)flown->num_layers + 2 + (size_t)flown->num_bodies,
                 count = (size_t)group->count;
    CML_TRY(cml_zeros(&group->more, media * count, sizeof *group->more, "the rows", err));
    for (size_t i = 0; i < count; i++) {
        CML_TRY(cml_sweep_read_row(sweep, group->row[i], &group->own[i], err));
        group->scene[i] = &group->own[i];
        for (size_t m = 0; m < media; m++)
            group->more[m * count + i] = group->scene[i]->media[m].mua - flown->media[m].mua;
    }
    return CML_OK;
}

/* Makes the identity of a flight: its bits depend on all of its rows. */
static cml_status identify_group(const struct cml_sweep_run *sweep, struct group *group,
                                 struct cml_error *err)
{
    size_t size = 0;
    FILE *out = open_memstream(&group->identity, &size);
    for (int i = 0; out && i < group->count; i++)
        cml_text_print(out, CML_TEXT("row %d set ", group->row[i] + 1), group->scene[i]->settings);
    if (out) fputs(sweep->identity, out);
    return cml_text_end(out, &group->identity, &size, "the run's identity", err);
}

/* Finds the rows of flight `number`, reads their scenes and computes their identity. The seed is that of the
 * first row. */
static cml_status prepare_group(const struct cml_sweep_run *sweep, int number, struct group *group,
                                uint64_t *seed, struct cml_error *err)
{
    CML_TRY(find_rows(sweep, number, group, err));
    CML_TRY(cml_sweep_row_seed(sweep, group->row[0], seed, err));
    CML_TRY(read_group(sweep, group, err));
    return sweep->identity ? identify_group(sweep, group, err) : CML_OK; /* `check` needs no identity */
}

/* Moves the records of a flown group to the sweep, and prints a line for each of its rows. */
static void take_records(struct cml_sweep_run *sweep, const struct group *group)
{
    for (int i = 0; i < group->count; i++) {
        const int row = group->row[i];
        sweep->rows.record[row] = group->record[i];
        group->record[i].json = NULL;
        sweep->rows.done[row] = true;
        sweep->rows.num_done++;
        cml_sweep_print_row(sweep, row, &sweep->rows.record[row]);
    }
}

/* Most cells in a thread for A(r,z) of all rows together, or for the means of detectors. */
#define MOST_CELLS 5e7

/* True if the rows can have A(z) and A(r,z). notes: shows why not. */
static bool reaches_depths(const struct cml_sweep_run *sweep, const struct group *group, bool notes)
{
    const struct cml_scene *flown = &group->flown;
    const struct cml_engine_rows rows = {.count = group->count, .more = group->more};
    const int blind = cml_engine_rows_blind_in(flown, &rows);
    const bool large = (double)flown->nr * flown->nz * group->count > MOST_CELLS;
    if (!sweep->options->engine_options.absorption) return false;
    if (blind < 0 && !large) return true;
    if (notes && large)
        cml_note("rows have no A_z and A_rz: %d rows of %d x %d bins are too many (expected at most %g bins)",
                 group->count, flown->nr, flown->nz, MOST_CELLS);
    else if (notes)
        cml_note("rows have no A_z and A_rz: in medium %d a row has mua above %g times mus (or, where mus = "
                 "0, times the mua of the palest row)",
                 blind, CML_ROW_MOST_SHARE / CML_ROW_SAMPLING);
    return false;
}

/* True if the rows have means of detectors, which take 64 batches. notes: shows why not. */
static bool keeps_means(const struct group *group, bool notes)
{
    const struct cml_scene *flown = &group->flown;
    const double media = flown->num_layers + 2.0 + flown->num_bodies,
                 cells = 2 * (2 * media + 1) * flown->num_detectors * group->count * CML_NUM_BATCHES;
    if (cells <= MOST_CELLS) return true;
    if (notes)
        cml_note("rows have no means of detectors: %d rows of %d detectors and %.0f media take %.3g bins "
                 "(expected at most %g)",
                 group->count, flown->num_detectors, media, cells, MOST_CELLS);
    return false;
}

/* Returns the engine options for a flight of rows. notes: shows which results the rows lack. */
static struct cml_engine_options options_of(const struct cml_sweep_run *sweep, const struct group *group,
                                            bool notes)
{
    struct cml_engine_options options = sweep->options->engine_options;
    const bool depths = reaches_depths(sweep, group, notes), means = keeps_means(group, notes);
    options.rows = (struct cml_engine_rows){.count = group->count,
                                            .more = group->more,
                                            .depths = depths,
                                            .times = options.absorption,
                                            .means = means};
    options.absorption = false;
    return options;
}

cml_status cml_sweep_check_groups(const struct cml_sweep_run *sweep, struct cml_engine_options *largest,
                                  struct cml_error *err)
{
    struct cml_options options = *sweep->options;
    double most = 0;
    for (int number = 0; number < sweep->num_groups; number++) {
        CML_AT_END(clear_group) struct group group = {0};
        uint64_t seed;
        CML_TRY(prepare_group(sweep, number, &group, &seed, err));
        options.engine_options = options_of(sweep, &group, false);
        CML_TRY(cml_check_memory(&options, &group.flown, NULL, err));
        const double bytes = cml_memory_of(&options, &group.flown, NULL).most;
        if (bytes <= most) continue;
        most = bytes;
        *largest = options.engine_options;
        largest->rows.more = NULL;
    }
    return CML_OK;
}

/* Flies group `number` of rows, which share one flight, and writes a result for each row. `looks`: `merge`
 * only checks which parts belong to the run, so there are no records. */
static cml_status fly_group(struct cml_sweep_run *sweep, int number, struct cml_error *err)
{
    struct cml_options options = *sweep->options;
    const bool looks = cml_part_files_looking(options.joined);
    struct cml_error why = {CML_OK, ""};
    CML_AT_END(clear_group) struct group group = {0};
    uint64_t seed = 0;
    cml_status status = cml_cluster_agree(prepare_group(sweep, number, &group, &seed, err), err);
    if (status == CML_OK) {
        options.engine_options = options_of(sweep, &group, cml_cluster_rank() == 0 && !looks);
        const struct cml_run_rows rows = {group.count, group.row, group.scene, group.record};
        const struct cml_run_call call = {.options = &options,
                                          .scene = &group.flown,
                                          .inputs = group.identity,
                                          .shared = &sweep->surfaces,
                                          .seed = seed,
                                          .row = group.row[0] + 1,
                                          .rows = &rows};
        struct cml_record none;
        status = cml_run_one(&call, &none, err);
        status = cml_sweep_add_safety(status, cml_pending_flush(&sweep->pending, false, &why), &why, err);
        if (!looks && (status == CML_OK || status == CML_E_NUMERIC)) take_records(sweep, &group);
    }
    return status;
}

cml_status cml_sweep_fly_groups(struct cml_sweep_run *sweep, struct cml_error *err)
{
    cml_status worst = CML_OK;
    for (int number = 0; number < sweep->num_groups; number++) {
        struct cml_error why;
        const cml_status status = fly_group(sweep, number, &why);
        if (status != CML_OK) *err = why;
        if (status == CML_E_NUMERIC) worst = status;
        if (status != CML_OK && status != CML_E_NUMERIC) return status;
    }
    cml_sweep_rows_print(&sweep->rows, sweep->options->json);
    return worst;
}
