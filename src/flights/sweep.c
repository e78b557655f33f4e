/* SPDX-License-Identifier: MIT */
#include "flights/sweep.h"

#include "base/text.h"
#include "base/version.h"
#include "simulation/beam_notes.h"
#include "simulation/scenes.h"
#include "simulation/simulation.h"
#include "flights/before.h"
#include "flights/one_run.h"
#include "flights/outputs.h"
#include "flights/sweep_flights.h"
#include "input/mci_settings.h"
#include "input/sweep/sweep_groups.h"
#include "output/files/hdf5_file.h"
#include "output/study/sweep_files.h"
#include "run/cluster/cluster.h"
#include "run/identity.h"
#include "run/join.h"
#include "run/stop.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Returns the path of a table of the sweep, "NAME.sweep.csv" and the like. */
static cml_status table_path(const struct cml_sweep_run *sweep, const char *suffix, char **path,
                             struct cml_error *err)
{
    CML_FREED char *name = NULL;
    CML_TRY(cml_report_path(sweep->base->scenes[0].output, suffix, &name, err));
    return cml_output_path(sweep->options, name, path, err);
}

/* ---- before the first row flies ---- */

/* Returns the row under which the checkpoint of a row is saved. With --reweight rows share a flight, and the
 * checkpoint has the name of the first row of the flight. */
static int row_of_checkpoint(const struct cml_sweep_run *sweep, int row)
{
    int first = 0;
    if (!sweep->group) return row;
    while (sweep->group[first] != sweep->group[row]) first++;
    return first;
}

/* Looks at the existing result of a row, for --resume. Without a checkpoint the row is flown again. A result
 * with more photons than the row ends the sweep, so that no work is lost; with --target-error the photons
 * are not known before. */
static cml_status look_at_result(struct cml_sweep_run *sweep, int row, const struct cml_scene *scene,
                                 struct cml_error *err)
{
    const struct cml_options *options = sweep->options;
    const uint64_t photons = options->target_error > 0 ? UINT64_MAX
                             : options->photons > 0    ? options->photons
                                                       : scene->photons;
    struct cml_scene other = {.output = NULL};
    CML_FREED char *path = NULL, *name = NULL, *checkpoint = NULL;
    CML_TRY(cml_output_path(options, scene->output, &path, err));
    if (access(path, F_OK) != 0) return CML_OK;
    CML_TRY(cml_sweep_row_output(sweep, row_of_checkpoint(sweep, row), &name, err));
    other.output = name;
    CML_TRY(cml_run_checkpoint(options, &other, &checkpoint, err));
    if (cml_has_checkpoint(checkpoint)) return CML_OK;
    CML_TRY(cml_before_keep_better(options, path, photons, err));
    if (sweep->num_anew++ == 0) (void)cml_describe_replaced(path, sweep->replaced);
    return CML_OK;
}

/* Reads the scene of a row, and checks it and an existing result. */
static cml_status check_row(struct cml_sweep_run *sweep, int row, struct cml_error *err)
{
    CML_AT_END(cml_scene_clear) struct cml_scene scene = {0};
    uint64_t seed;
    CML_TRY(cml_sweep_row_seed(sweep, row, &seed, err));
    CML_TRY(cml_sweep_read_row(sweep, row, &scene, err));
    cml_status status = cml_simulation_check(sweep->options, &scene, &sweep->surfaces, err);
    if (status == CML_OK && sweep->options->resume && sweep->options->parts == 0)
        status = look_at_result(sweep, row, &scene, err);
    return cml_sweep_name_row(sweep, row, status, err);
}

/* Claims the outputs of the tables and of all rows, as if each were a run of one file. Tables count as runs
 * without map, facets and saved packets. */
static cml_status claim(struct cml_sweep_run *sweep, struct cml_scene *scenes, struct cml_error *err)
{
    static const char *const suffixes[] = {".sweep.csv", ".sweep.h5"};
    /* a part has no tables */
    const int rows = sweep->table.num_rows, tables = sweep->options->parts > 0 ? 0
                                                     : cml_hdf5_available()    ? 2
                                                                               : 1;
    const struct cml_scene_list list = {rows + tables, scenes};
    cml_status status = CML_OK;
    for (int i = 0; i < list.count; i++) {
        scenes[i] = sweep->base->scenes[0];
        scenes[i].output = scenes[i].saved.name = NULL;
    }
    for (int i = 0; i < tables; i++) {
        scenes[i].format = i == 0 ? 'A' : 'B';
        scenes[i].map = (struct cml_map_def){0};
        scenes[i].facets = false;
        scenes[i].saved.limit = 0;
    }
    for (int i = 0; status == CML_OK && i < list.count; i++)
        status = i < tables
                     ? cml_report_path(sweep->base->scenes[0].output, suffixes[i], &scenes[i].output, err)
                     : cml_sweep_row_output(sweep, i - tables, &scenes[i].output, err);
    for (int i = tables; status == CML_OK && i < list.count; i++)
        status = cml_sweep_name_saved(sweep, i - tables, &scenes[i].saved.name, err);
    if (status == CML_OK)
        status = cml_outputs_claim(sweep->options, &list, 1, sweep->inputs, &sweep->outputs, err);
    for (int i = 0; i < list.count; i++) {
        free(scenes[i].output);
        free(scenes[i].saved.name);
    }
    return status;
}

/* Checks all rows of the sweep and their flights on rank 0, and claims the files that they will write. */
static cml_status check_rows(struct cml_sweep_run *sweep, struct cml_error *err)
{
    struct cml_engine_options ignored = sweep->options->engine_options;
    for (int row = 0; row < sweep->table.num_rows; row++) CML_TRY(check_row(sweep, row, err));
    CML_TRY(cml_sweep_check_groups(sweep, &ignored, err));
    if (sweep->options->receiver) return CML_OK;
    CML_FREED struct cml_scene *scenes = NULL;
    CML_TRY(cml_zeros(&scenes, (size_t)sweep->table.num_rows + 2, sizeof *scenes, "the rows", err));
    return claim(sweep, scenes, err);
}

/* Makes the identity without the table: the result of a row depends on its own cells only. */
static cml_status identify(struct cml_sweep_run *sweep, struct cml_error *err)
{
    struct cml_inputs files = *sweep->inputs;
    files.count--;
    return cml_identity_inputs(&files, &sweep->identity, err);
}

/* True if an earlier column of the sweep's table would have the same name in the .h5. */
static bool is_taken(const struct cml_sweep_table *table, int column, const char *name)
{
    char other[CML_SETTING_NAME];
    for (int c = 0; c < column; c++) {
        strcpy(other, table->name[c]);
        cml_sweep_h5_name(other);
        if (strcmp(other, name) == 0) return true;
    }
    return false;
}

/* Refuses labels whose names are in use in the tables of results, or impossible in the .h5, where "." is the
 * file itself. */
static cml_status check_labels(const struct cml_sweep_table *table, struct cml_error *err)
{
    char name[CML_SETTING_NAME];
    for (int c = 0; c < table->num_columns; c++) {
        strcpy(name, table->name[c]);
        cml_sweep_h5_name(name);
        const char *expected = !table->label[c] ? NULL
                               : cml_sweep_is_of_results(name)
                                   ? "a name that the table of results has not already"
                               : strcmp(name, ".") == 0   ? "a name other than ."
                               : is_taken(table, c, name) ? "a name that no other column has, with _ for /"
                                                          : NULL;
        if (expected)
            return cml_fail_field(err, table->text.path, table->names_line, "label", table->name[c],
                                  expected);
    }
    return CML_OK;
}

/* ---- columns that are set, and labels ---- */

/* Refuses a quoted column name (a label) that is the name of a setting, because the user probably meant to
 * set the value. */
static cml_status fail_label(const struct cml_sweep_table *table, int column, struct cml_error *err)
{
    return cml_fail_field(err, table->text.path, table->names_line, CML_TEXT("column %d", column + 1),
                          table->name[column],
                          "the name without quotation marks, if it is to be set; a label has a name that "
                          "nothing in the scene has");
}

/* Finds the columns that are labels. A quoted name is a label, and must not be a name of the scene. Programs
 * that write tables may leave the quotation marks out: a name that resembles no name of the scene is then a
 * label, too, if other columns set something. Any other name is left to the reader of the rows, which refuses
 * it. */
static cml_status find_labels(struct cml_sweep_run *sweep, const struct cml_scene *scene,
                              struct cml_error *err)
{
    struct cml_sweep_table *table = &sweep->table;
    bool known[CML_MOST_SETTINGS];
    int num_meant = 0;
    for (int c = 0; c < table->num_columns; c++) {
        CML_TRY(cml_mci_is_setting(scene, table->name[c], &known[c], err));
        known[c] = known[c] || strcmp(table->name[c], "seed") == 0;
        if (known[c] && table->label[c]) return fail_label(table, c, err);
        num_meant += known[c] || cml_mci_resembles_setting(table->name[c]);
    }
    for (int c = 0; num_meant > 0 && c < table->num_columns; c++) {
        if (known[c] || table->label[c] || cml_mci_resembles_setting(table->name[c])) continue;
        table->label[c] = sweep->unmarked[c] = true;
    }
    return CML_OK;
}

/* Returns the layer that a column sets a number of; 0: none. */
static int layer_of(const struct cml_sweep_table *table, int column, const struct cml_scene *scene)
{
    return table->label[column] ? 0 : cml_mci_layer_of(scene, table->name[column]);
}

/* Notes a table that sets a layer by its number although the scene has bodies, or more layers than the table
 * sets: a layer's number changes when a layer is added above, and bodies have numbers of their own. Layers
 * with names are not noted. */
static void note_numbers(const struct cml_sweep_table *table, const struct cml_scene *scene)
{
    int count = 0, numbered = 0;
    for (int c = 0; c < table->num_columns; c++) {
        const int layer = layer_of(table, c, scene);
        int before = 0;
        while (before < c && layer_of(table, before, scene) != layer) before++;
        count += layer > 0 && before == c;
        if (layer > 0 && !*cml_layer_name(scene, layer)) numbered = layer;
    }
    if (!numbered) return;
    if (scene->num_bodies == 0 && count == scene->num_layers) return;
    cml_note("%.300s: layer%d counts from above, in a scene of %d layer%s and %d bod%s; name=NAME behind the "
             "numbers of a layer lets columns say NAME.mua",
             table->text.path, numbered, scene->num_layers, scene->num_layers == 1 ? "" : "s",
             scene->num_bodies, scene->num_bodies == 1 ? "y" : "ies");
}

/* Notes labels without quotation marks and numbered layers, on rank 0 when all rows are valid. */
static void note_columns(const struct cml_sweep_run *sweep)
{
    const struct cml_sweep_table *table = &sweep->table;
    for (int c = 0; c < table->num_columns; c++)
        if (sweep->unmarked[c])
            cml_note("%.300s:%d: column %d, %s, is a label: the scene has no number of that name",
                     table->text.path, table->names_line, c + 1, table->name[c]);
    note_numbers(table, &sweep->base->scenes[0]);
}

/* Returns the medium of which a column of the table sets a number (layer1.mua, body2.n ...); -1: none. */
static int medium_of(const struct cml_sweep_table *table, int column, const struct cml_scene *scene)
{
    const int layer = layer_of(table, column, scene);
    int body;
    if (layer > 0) return layer;
    if (table->label[column] || sscanf(table->name[column], "body%d.", &body) != 1 || body < 1 ||
        body > scene->num_bodies)
        return -1;
    return cml_body_medium(scene, body - 1);
}

/* Returns the column that sets the scattering of a medium (its name ends in .mus), or -1. */
static int scattering_column(const struct cml_sweep_table *table, int medium, const struct cml_scene *scene)
{
    for (int c = 0; c < table->num_columns; c++) {
        const char *dot = strrchr(table->name[c], '.');
        if (dot && strcmp(dot, ".mus") == 0 && medium_of(table, c, scene) == medium) return c;
    }
    return -1;
}

/* Finds which rows of a sweep may share a flight: those that differ only in absorption. For each column,
 * tells cml_sweep_group which medium it belongs to and which column sets the medium's scattering. */
static cml_status group_rows(struct cml_sweep_run *sweep, struct cml_error *err)
{
    const struct cml_sweep_table *table = &sweep->table;
    const struct cml_scene *scene = &sweep->base->scenes[0];
    CML_FREED struct cml_sweep_medium *media = NULL;
    CML_TRY(cml_zeros(&media, (size_t)table->num_columns, sizeof *media, "the columns", err));
    for (int c = 0; c < table->num_columns; c++) {
        const int medium = medium_of(table, c, scene);
        media[c] = (struct cml_sweep_medium){medium == 1, -1, 0};
        if (medium < 0) continue;
        media[c].scattering = scattering_column(table, medium, scene);
        media[c].mus = scene->media[medium].mus;
    }
    return cml_sweep_group(table, media, &sweep->group, &sweep->num_groups, err);
}

/* Reads and checks the table as far as possible before its rows are read as scenes. */
static cml_status read_table(struct cml_sweep_run *sweep, struct cml_error *err)
{
    const struct cml_text_source replay = cml_inputs_replayer(sweep->inputs);
    const struct cml_options *options = sweep->options;
    const struct cml_scene *scene = &sweep->base->scenes[0];
    if (sweep->base->count != 1)
        return cml_fail(err, CML_E_INPUT, "--sweep %.80s (expected a file with one run; %.400s has %d)",
                        options->sweep, options->operands[0], sweep->base->count);
    if (options->reweight && scene->saved.limit)
        return cml_fail(err, CML_E_INPUT,
                        "%s:%d: a photons line and --reweight, whose rows have no packets of their own "
                        "(expected no such line)",
                        scene->file, scene->saved.line);
    CML_TRY(cml_sweep_table_read(&replay, options->sweep, &sweep->table, err));
    CML_TRY(find_labels(sweep, scene, err));
    sweep->seed_column = -1;
    for (int c = 0; c < sweep->table.num_columns; c++)
        if (strcmp(sweep->table.name[c], "seed") == 0 && !sweep->table.label[c]) sweep->seed_column = c;
    CML_TRY(check_labels(&sweep->table, err));
    if (options->reweight) CML_TRY(cml_sweep_check_reweighted(scene, err));
    sweep->digits = snprintf(NULL, 0, "%d", sweep->table.num_rows);
    if (sweep->digits < 4) sweep->digits = 4;
    return options->reweight ? group_rows(sweep, err) : CML_OK;
}

/* Prepares a sweep: table, identity, the surfaces that rows share, and a check of all rows. */
static cml_status open_sweep(struct cml_sweep_run *sweep, struct cml_error *err)
{
    const struct cml_options *options = sweep->options;
    CML_TRY(read_table(sweep, err));
    CML_TRY(identify(sweep, err));
    CML_TRY(cml_surfaces_create(&sweep->base->scenes[0], &options->surface, &sweep->surfaces, err));
    if (cml_cluster_rank() == 0) CML_TRY(check_rows(sweep, err));
    if (cml_cluster_rank() == 0) note_columns(sweep);
    if (cml_cluster_rank() == 0) CML_TRY(cml_note_beam(&sweep->base->scenes[0], &sweep->surfaces, NULL, err));
    return cml_sweep_rows_create(sweep->table.num_rows, &sweep->rows, err);
}

/* ---- flying ---- */

/* Flies one row of a sweep and writes its result. It is the cml_sweep_fly_function of cml_sweep_rows_fly;
 * `context` is the sweep. */
static cml_status fly_row(void *context, int row, struct cml_record *record, struct cml_error *err)
{
    struct cml_sweep_run *sweep = context;
    CML_AT_END(cml_scene_clear) struct cml_scene scene = {0};
    struct cml_error why = {CML_OK, ""};
    uint64_t seed = 0;
    cml_status status = cml_sweep_row_seed(sweep, row, &seed, err);
    if (status == CML_OK) status = cml_sweep_read_row(sweep, row, &scene, err);
    CML_TRY(cml_cluster_agree(status, err));
    const struct cml_run_call call = {.options = sweep->options,
                                      .scene = &scene,
                                      .inputs = sweep->identity,
                                      .shared = &sweep->surfaces,
                                      .seed = seed,
                                      .row = row + 1,
                                      .pending = &sweep->pending,
                                      .stays = true};
    status = cml_run_one(&call, record, err);
    if (status == CML_E_INPUT) status = cml_sweep_name_row(sweep, row, status, err);
    status = cml_sweep_add_safety(status, cml_pending_flush(&sweep->pending, false, &why), &why, err);
    const bool looks = cml_part_files_looking(sweep->options->joined);
    if (!looks && (status == CML_OK || status == CML_E_NUMERIC)) cml_sweep_print_row(sweep, row, record);
    return status;
}

/* Reads the parts of all rows for `merge` before the first result is written, so that a missing part spoils
 * nothing. */
static cml_status look_at_parts(struct cml_sweep_run *sweep, struct cml_error *err)
{
    struct cml_part_files *files = sweep->options->joined;
    struct cml_record none;
    cml_status status = CML_OK;
    if (!files) return CML_OK;
    files->looking = true;
    if (sweep->group) status = cml_sweep_fly_groups(sweep, err);
    for (int row = 0; !sweep->group && status == CML_OK && row < sweep->table.num_rows; row++)
        status = fly_row(sweep, row, &none, err);
    return cml_part_files_looked(files, status, err);
}

/* ---- results of the sweep ---- */

/* Writes the results of all rows as .csv and, if the program has HDF5, as .h5. */
static cml_status write_tables(const struct cml_sweep_run *sweep, const struct cml_sweep_results *results,
                               struct cml_error *err)
{
    CML_FREED char *csv = NULL, *h5 = NULL;
    CML_TRY(table_path(sweep, ".sweep.csv", &csv, err));
    CML_TRY(cml_sweep_write_csv(csv, results, err));
    CML_TRY(table_path(sweep, ".sweep.h5", &h5, err));
    if (cml_hdf5_available()) CML_TRY(cml_sweep_write_h5(h5, results, err));
    if (!sweep->options->quiet && !sweep->options->json) {
        printf("  -> %s\n", csv);
        if (cml_hdf5_available()) printf("  -> %s\n", h5);
    }
    return CML_OK;
}

/* Writes the tables of a finished sweep on rank 0, with the names of files and the seeds of all rows. */
static cml_status publish(const struct cml_sweep_run *sweep, struct cml_error *err)
{
    const struct cml_scene *base = &sweep->base->scenes[0];
    const size_t rows = (size_t)sweep->table.num_rows, columns = (size_t)sweep->table.num_columns;
    char **files = calloc(rows, sizeof *files);
    const char **names = calloc(columns, sizeof *names);
    const char *detectors[CML_RECORD_MEDIA];
    for (int k = 0; k < base->num_detectors && k < CML_RECORD_MEDIA; k++)
        detectors[k] = base->detectors[k].name;
    uint64_t *seeds = calloc(rows, sizeof *seeds);
    cml_status status =
        files && names && seeds ? CML_OK : cml_fail_memory(err, 16.0 * (double)rows, "the rows");
    for (size_t c = 0; status == CML_OK && c < columns; c++) names[c] = sweep->table.name[c];
    for (size_t i = 0; status == CML_OK && i < rows; i++) {
        status = cml_sweep_row_output(sweep, (int)i, &files[i], err);
        if (status == CML_OK) status = cml_sweep_row_seed(sweep, (int)i, &seeds[i], err);
    }
    const struct cml_sweep_results results = {.title = base->output,
                                              .input = base->text,
                                              .settings = base->settings,
                                              .call = {sweep->options->command, base->file},
                                              .num_columns = (int)columns,
                                              .num_rows = (int)rows,
                                              .name = names,
                                              .label = sweep->table.label,
                                              .cell = sweep->table.cell,
                                              .seed = seeds,
                                              .file = files,
                                              .record = sweep->rows.record,
                                              .detector = detectors};
    if (status == CML_OK) status = write_tables(sweep, &results, err);
    for (size_t i = 0; files && i < rows; i++) free(files[i]);
    free(files);
    free(names);
    free(seeds);
    return status;
}

/* Removes the checkpoints of all rows, on rank 0, unless they are to stay. */
static void remove_checkpoints(const struct cml_sweep_run *sweep)
{
    const struct cml_options *options = sweep->options;
    struct cml_error ignored;
    for (int row = 0; !cml_run_leaves_checkpoints(options) && row < sweep->table.num_rows; row++) {
        CML_FREED char *output = NULL, *path = NULL;
        struct cml_scene scene = sweep->base->scenes[0];
        if (cml_sweep_row_output(sweep, row, &output, &ignored) != CML_OK) continue;
        scene.output = output;
        if (cml_run_checkpoint(options, &scene, &path, &ignored) == CML_OK) cml_checkpoint_remove(path);
    }
}

/* Ends a sweep on rank 0: writes the tables and removes checkpoints. Returns the status `flown`, or a
 * failure. */
static cml_status finish(const struct cml_sweep_run *sweep, cml_status flown, struct cml_error *err)
{
    if (flown == CML_E_STOPPED)
        return cml_fail(err, CML_E_STOPPED, "%s: stopped with %d of %d row%s to fly; --resume continues",
                        sweep->base->scenes[0].output, sweep->table.num_rows - sweep->rows.num_done,
                        sweep->table.num_rows, sweep->table.num_rows == 1 ? "" : "s");
    if ((flown != CML_OK && flown != CML_E_NUMERIC) || sweep->options->parts > 0) return flown;
    CML_TRY(publish(sweep, err));
    if (sweep->options->checkpoint_interval > 0) remove_checkpoints(sweep);
    return flown;
}

/* Prints how many rows a sweep has, and in how many flights they are flown. */
static void announce(const struct cml_sweep_run *sweep)
{
    printf("clustermcml %s, %d rank%s: %d row%s of %s", cml_version(), cml_cluster_size(),
           cml_cluster_size() == 1 ? "" : "s", sweep->table.num_rows, sweep->table.num_rows == 1 ? "" : "s",
           sweep->options->sweep);
    if (sweep->group) printf(" in %d flight%s", sweep->num_groups, sweep->num_groups == 1 ? "" : "s");
    printf("\n");
}

/* Notes that the table of an earlier sweep is replaced, which means that the results of its rows are
 * replaced, too. */
static void note_replaced(const struct cml_sweep_run *sweep)
{
    CML_FREED char *csv = NULL;
    char text[CML_REPLACED];
    struct cml_error ignored;
    if (table_path(sweep, ".sweep.csv", &csv, &ignored) == CML_OK && cml_describe_replaced(csv, text))
        cml_show_note(NULL, text);
}

/* Flies all rows, makes their results safe on the disk and writes the tables of the sweep. */
static cml_status fly(struct cml_sweep_run *sweep, struct cml_error *err)
{
    const struct cml_options *options = sweep->options;
    struct cml_error why = {CML_OK, ""};
    const bool replaces = !options->resume && options->parts == 0;
    if (cml_cluster_rank() == 0 && !options->quiet && replaces) note_replaced(sweep);
    if (cml_cluster_rank() == 0 && sweep->num_anew > 0)
        cml_note(
            "--resume finds no checkpoint of %d of %d rows whose results are there: they begin anew; %s%s",
            sweep->num_anew, sweep->table.num_rows, sweep->replaced,
            sweep->num_anew > 1 ? ", and others" : "");
    if (options->checkpoint_interval > 0) cml_stop_watch();
    if (cml_cluster_rank() == 0 && !options->quiet && !options->json) announce(sweep);
    if (!options->receiver) cml_pending_begin(&sweep->pending);
    cml_status status = sweep->group ? cml_sweep_fly_groups(sweep, err)
                                     : cml_sweep_rows_fly(&sweep->rows, options->json, fly_row, sweep, err);
    if (options->receiver) return status;
    const bool complete = status == CML_OK || status == CML_E_NUMERIC;
    const bool marks = !complete || cml_run_leaves_checkpoints(options);
    status = cml_sweep_add_safety(status, cml_pending_end(&sweep->pending, marks, &why), &why, err);
    if (cml_cluster_rank() == 0) status = finish(sweep, status, err);
    return cml_cluster_agree(status, err);
}

/* Frees a sweep and releases its files. */
static void clear_sweep(struct cml_sweep_run *sweep)
{
    cml_sweep_rows_clear(&sweep->rows);
    cml_outputs_release(&sweep->outputs);
    cml_surfaces_free(&sweep->surfaces);
    cml_sweep_table_clear(&sweep->table);
    free(sweep->identity);
    free(sweep->group);
}

cml_status cml_sweep(const struct cml_options *options, const struct cml_scene_list *list,
                     struct cml_inputs *inputs, struct cml_error *err)
{
    struct cml_sweep_run sweep = {.options = options, .base = list, .inputs = inputs};
    cml_status status = cml_cluster_agree(open_sweep(&sweep, err), err);
    if (status == CML_OK) status = look_at_parts(&sweep, err);
    if (status == CML_OK) status = fly(&sweep, err);
    clear_sweep(&sweep);
    return status;
}

cml_status cml_sweep_check(const struct cml_options *options, const struct cml_scene_list *list,
                           struct cml_inputs *inputs, struct cml_sweep_size *size,
                           struct cml_engine_options *largest, struct cml_error *err)
{
    struct cml_sweep_run sweep = {.options = options, .base = list, .inputs = inputs};
    cml_status status = cml_sweep_check_options(options, err);
    if (status == CML_OK && options->sweep) status = read_table(&sweep, err);
    if (status == CML_OK && options->sweep && cml_scene_starts_inside(&list->scenes[0]))
        status = cml_surfaces_create(&list->scenes[0], &options->surface, &sweep.surfaces, err);
    for (int row = 0; status == CML_OK && row < sweep.table.num_rows; row++)
        status = check_row(&sweep, row, err);
    if (status == CML_OK) status = cml_sweep_check_groups(&sweep, largest, err);
    if (status == CML_OK) note_columns(&sweep);
    const int rows = sweep.table.num_rows;
    *size = (struct cml_sweep_size){rows, sweep.group ? sweep.num_groups : rows};
    clear_sweep(&sweep);
    return status;
}
