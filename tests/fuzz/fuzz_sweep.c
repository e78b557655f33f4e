/* Fuzzes tables of sweeps: reads them and puts the first rows into a scene. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "input/mci.h"
#include "input/sweep/sweep_table.h"

enum { MOST_ROWS = 4 };

static const char scene_text[] =
    "1.0\n1\ns.mco A\n100\n0.1 0.1\n3 4 2\nbeam disk 0.1\n2\n1\nb 2 -0.1 0.2 0 1\n"
    "1.4 0.5 20 0.8 1\ni sphere 0 0 0.5 0.3 1.33 1 10 0.9\n1.3 0 5 -1 2\n1.5\n";

/* Puts a row into the scene: each cell is accepted or refused, and an accepted value is the one written. */
static void put_row(const struct cml_sweep_table *table, int row)
{
    struct cml_settings settings = {0};
    struct cml_error err = {CML_OK, ""};
    cml_status status = CML_OK;
    for (int c = 0; c < table->num_columns && status == CML_OK; c++) {
        const struct cml_setting cell = cml_sweep_cell(table, row, c);
        uint64_t count;
        FUZZ_CHECK(cell.value[0] != '\0' && cell.name[0] != '\0' && cell.line > 0);
        if (cml_parse_count(cell.value, &count)) FUZZ_CHECK(count <= (uint64_t)1 << 53);
        if (!table->label[c]) status = cml_settings_copy(&settings, &cell, &err);
    }
    struct fuzz_files files = {(const uint8_t *)scene_text, sizeof scene_text - 1};
    const struct cml_text_source source = fuzz_source(&files);
    const struct cml_input_options options = {.source = &source, .settings = &settings, .tolerance = 1e-3};
    struct cml_scene_list list;
    if (status == CML_OK) status = cml_mci_read("scene.mci", &options, &list, &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return;
    }
    FUZZ_CHECK(list.count == 1 && list.scenes[0].photons >= 1);
    cml_scene_list_clear(&list);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct cml_sweep_table table;
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_sweep_table_read(NULL, fuzz_file(data, size), &table, &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        FUZZ_CHECK(table.cell == NULL && table.text.data == NULL);
        return 0;
    }
    FUZZ_CHECK(table.num_columns >= 1 && table.num_rows >= 1);
    for (int row = 0; row < table.num_rows && row < MOST_ROWS; row++) put_row(&table, row);
    cml_sweep_table_clear(&table);
    return 0;
}
