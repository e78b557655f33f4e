/* SPDX-License-Identifier: MIT */
#include "flights/sweep_scenes.h"

#include "base/text.h"
#include "simulation/scenes.h"
#include "output/report.h"
#include "run/cluster/cluster.h"

#include <stdlib.h>
#include <string.h>

cml_status cml_sweep_row_output(const struct cml_sweep_run *sweep, int row, char **name,
                                struct cml_error *err)
{
    const struct cml_scene *scene = &sweep->base->scenes[0];
    CML_FREED char *stem = NULL;
    CML_TRY(cml_report_path(scene->output, "", &stem, err));
    const char *ending = scene->format == 'B' ? ".h5" : scene->output + strlen(stem);
    return cml_text_format(name, "a name", err, "%s-%0*d%s", stem, sweep->digits, row + 1, ending);
}

cml_status cml_sweep_name_saved(const struct cml_sweep_run *sweep, int row, char **name,
                                struct cml_error *err)
{
    const char *of_all = sweep->base->scenes[0].saved.name;
    if (!of_all) return CML_OK;
    free(*name);
    return cml_text_format(name, "a name", err, "%s-%0*d", of_all, sweep->digits, row + 1);
}

cml_status cml_sweep_row_settings(const struct cml_sweep_run *sweep, int row, struct cml_settings *settings,
                                  struct cml_error *err)
{
    *settings = sweep->options->settings;
    for (int c = 0; c < sweep->table.num_columns; c++) {
        const struct cml_setting setting = cml_sweep_cell(&sweep->table, row, c);
        if (c != sweep->seed_column && !sweep->table.label[c])
            CML_TRY(cml_settings_copy(settings, &setting, err));
    }
    return CML_OK;
}

/* Finds the seed of a row: that of the column `seed`, or of --seed if there is no such column. Both together
 * are refused. */
cml_status cml_sweep_row_seed(const struct cml_sweep_run *sweep, int row, uint64_t *seed,
                              struct cml_error *err)
{
    *seed = sweep->options->engine_options.seed;
    if (sweep->seed_column < 0) return CML_OK;
    const struct cml_setting setting = cml_sweep_cell(&sweep->table, row, sweep->seed_column);
    if (sweep->options->seed_given) return cml_setting_fail(&setting, "no value beside that of --seed", err);
    if (cml_parse_count(setting.value, seed)) return CML_OK;
    return cml_setting_fail(&setting, "a whole number from 0 to 9007199254740992", err);
}

cml_status cml_sweep_name_row(const struct cml_sweep_run *sweep, int row, cml_status status,
                              struct cml_error *err)
{
    const struct cml_error why = *err;
    const char *path = sweep->table.text.path;
    char cells[300] = "";
    if (status == CML_OK || strncmp(why.text, path, strlen(path)) == 0) return status;
    for (int c = 0; c < sweep->table.num_columns && strlen(cells) < 200; c++) {
        const struct cml_setting cell = cml_sweep_cell(&sweep->table, row, c);
        snprintf(cells + strlen(cells), sizeof cells - strlen(cells), ", %s = %.30s", cell.name, cell.value);
    }
    return cml_fail(err, status, "%s:%d: row %d%s: %.600s", path, sweep->table.line[row], row + 1, cells,
                    why.text);
}

cml_status cml_sweep_read(const struct cml_sweep_run *sweep, int row, const struct cml_settings *settings,
                          struct cml_scene *scene, struct cml_error *err)
{
    CML_FREED char *output = NULL;
    CML_TRY(cml_sweep_row_output(sweep, row, &output, err));
    cml_status status =
        cml_copy_scene(sweep->options, settings, output, sweep->inputs, &sweep->base->scenes[0], scene, err);
    if (status == CML_OK) status = cml_sweep_name_saved(sweep, row, &scene->saved.name, err);
    return cml_sweep_name_row(sweep, row, status, err);
}

cml_status cml_sweep_read_row(const struct cml_sweep_run *sweep, int row, struct cml_scene *scene,
                              struct cml_error *err)
{
    struct cml_settings settings;
    CML_TRY(cml_sweep_row_settings(sweep, row, &settings, err));
    return cml_sweep_read(sweep, row, &settings, scene, err);
}

void cml_sweep_print_row(const struct cml_sweep_run *sweep, int row, const struct cml_record *record)
{
    const struct cml_sweep_table *table = &sweep->table;
    const struct cml_options *options = sweep->options;
    if (options->quiet || options->json || cml_cluster_rank() != 0) return;
    printf("  row %d of %d:", row + 1, table->num_rows);
    for (int c = 0; c < table->num_columns; c++)
        printf(" %s=%s", table->name[c], table->cell[(size_t)row * (size_t)table->num_columns + (size_t)c]);
    const char *before = "  ";
    for (int t = 0; t < CML_NUM_TOTALS; t++) {
        const int at = t == CML_TOTAL_FACE ? cml_record_find(record, CML_RECORDED_FACE, 0)
                                           : cml_record_find(record, CML_RECORDED_TOTALS, t);
        if (at < 0 || (t == CML_TOTAL_SPECULAR && !(record->value[at] > 0))) continue;
        printf("%s%s", before, cml_quantities[cml_quantity_of_total(t)].name);
        cml_report_estimate(stdout, record->value[at], record->error[at]);
        before = ", ";
    }
    putchar('\n');
    fflush(stdout);
}

cml_status cml_sweep_add_safety(cml_status status, cml_status safe, struct cml_error *why,
                                struct cml_error *err)
{
    safe = cml_cluster_agree(safe, why);
    if (safe == CML_OK || (status != CML_OK && status != CML_E_NUMERIC && status != CML_E_STOPPED))
        return status;
    *err = *why;
    return safe;
}
