/* SPDX-License-Identifier: MIT */
#include "result/h5.h"

#include "base/text.h"
#include "result/mco.h"
#include "result/mco_sections.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

cml_status cml_result_read(const char *path, struct cml_outcome *o, struct cml_error *err)
{
    CML_TRY(cml_file_ends_in(path, ".h5") ? cml_h5_read(path, o, err) : cml_mco_read(path, o, err));
    if (!o->damage) return CML_OK;
    const cml_status status = cml_fail(err, CML_E_INPUT, "%s", o->damage);
    cml_outcome_clear(o);
    return status;
}

#ifdef CML_HDF5

struct reader {
    struct cml_hdf5 file;
    struct cml_outcome *o;
    struct cml_error *err;
};

/* ---- arrays ---- */

/* Errors may be unknown, of one packet, and means be those of nothing: NaN. */
static cml_status read_values(const struct cml_hdf5_dataset *dataset, double *out, struct cml_error *err)
{
    const bool may_be_none = cml_quantity_is_errors(dataset->name) || cml_outcome_may_be_none(dataset->name);
    CML_TRY(cml_hdf5_values(dataset, 0, dataset->size, out, err));
    for (size_t i = 0; i < dataset->size; i++)
        if (!isfinite(out[i]) && !(may_be_none && isnan(out[i])))
            return cml_fail(err, CML_E_INPUT, "%.400s: %s[%zu] = %g (expected a finite number)",
                            dataset->file->path, dataset->name, i, out[i]);
    return CML_OK;
}

static cml_status read_dataset(const struct cml_hdf5_dataset *dataset, size_t count, double **values,
                               struct cml_error *err)
{
    if (count > 0 && dataset->size != count)
        return cml_fail(err, CML_E_INPUT, "%.400s: %.80s has %zu numbers (expected %zu)", dataset->file->path,
                        dataset->name, dataset->size, count);
    *values = malloc(dataset->size * sizeof **values);
    if (!*values) return cml_fail_memory(err, 8.0 * (double)dataset->size, dataset->name);
    const cml_status status = read_values(dataset, *values, err);
    if (status == CML_OK) return CML_OK;
    free(*values);
    *values = NULL;
    return status;
}

cml_status cml_h5_numbers(const struct cml_hdf5 *file, const char *name, size_t count, double **values,
                          struct cml_hdf5_dataset *shape, struct cml_error *err)
{
    struct cml_hdf5_dataset dataset;
    *values = NULL;
    CML_TRY(cml_hdf5_dataset_open(file, name, &dataset, err));
    if (shape) *shape = dataset;
    if (dataset.id == 0) return CML_OK;
    const cml_status status = read_dataset(&dataset, count, values, err);
    cml_hdf5_dataset_close(&dataset);
    return status;
}

/* ---- grid ---- */

enum { MUST_BE_THERE = -1 };

/* Number and width of the bins of an axis, whose first middle is half a width; `without` bins where the file
 * has none of this name, as when nothing was tallied over it. */
static cml_status read_axis(const struct reader *r, const char *name, int without, int *n, double *width)
{
    const size_t most = 100000000;
    double *middle;
    struct cml_hdf5_dataset shape;
    CML_TRY(cml_h5_numbers(&r->file, name, 0, &middle, &shape, r->err));
    const bool missing = !middle;
    *n = middle && shape.num_axes == 1 && shape.size <= most ? (int)shape.size : without;
    *width = middle ? 2 * middle[0] : 1;
    free(middle);
    if (missing ? without != MUST_BE_THERE : *n > 0 && *width > 0) return CML_OK;
    return cml_fail(r->err, CML_E_INPUT, "%.400s: no axis %s (expected the .h5 file of a run)", r->file.path,
                    name);
}

static cml_status read_grid(const struct reader *r)
{
    struct cml_outcome *o = r->o;
    double width;
    CML_TRY(read_axis(r, "r", MUST_BE_THERE, &o->nr, &o->dr));
    CML_TRY(read_axis(r, "alpha", MUST_BE_THERE, &o->na, &width));
    CML_TRY(read_axis(r, "z", 1, &o->nz, &o->dz));
    CML_TRY(read_axis(r, "layer", MUST_BE_THERE, &o->num_layers, &width));
    CML_TRY(read_axis(r, "body", 0, &o->num_bodies, &width));
    CML_TRY(read_axis(r, "gate", 0, &o->num_gates, &width));
    o->time_end = o->num_gates * width;
    CML_TRY(read_axis(r, "theta", 0, &o->nt, &width));
    CML_TRY(read_axis(r, "phi", o->nt > 0 ? MUST_BE_THERE : 0, &o->np, &width));
    const double most = (double)cml_hdf5_most_numbers(&r->file);
    if (cml_outcome_numbers(o) > most)
        return cml_fail(
            r->err, CML_E_INPUT,
            "%.400s: nz nr na = %d %d %d (expected no more than the %.0f numbers the file can hold)",
            r->file.path, o->nz, o->nr, o->na, most);
    return cml_outcome_allocate(o, r->err);
}

/* ---- where it comes from ---- */

static cml_status read_photons(const struct reader *r)
{
    double photons = 0;
    char *identity = NULL;
    CML_TRY(cml_hdf5_text(&r->file, NULL, "title", &r->o->output, r->err));
    CML_TRY(cml_hdf5_text(&r->file, NULL, "version", &r->o->program, r->err));
    CML_TRY(cml_hdf5_text(&r->file, NULL, "identity", &identity, r->err));
    if (identity) snprintf(r->o->identity, sizeof r->o->identity, "%s", identity);
    free(identity);
    CML_TRY(cml_hdf5_number(&r->file, "photons", &photons, r->err));
    if (!(photons >= 1 && photons <= 0x1p53 && photons == floor(photons)))
        return cml_fail(r->err, CML_E_INPUT, "%.400s: photons = %g (expected a whole number of 1 or more)",
                        r->file.path, photons);
    r->o->photons = (uint64_t)photons;
    return CML_OK;
}

/* Reads the options that decide bits; of those that are words in the file the other word means not 0. */
static cml_status read_options(const struct reader *r)
{
    struct cml_provenance *p = &r->o->provenance;
    char *text;
    for (int i = 0; i < CML_NUM_OPTIONS_OF_BITS; i++) {
        const struct cml_option_info *info = &cml_options_of_bits[i];
        if (!(info->where & CML_IN_H5)) continue;
        if (!(info->where & CML_AS_WORD)) {
            CML_TRY(cml_hdf5_number(&r->file, info->name, &p->value[i], r->err));
            continue;
        }
        CML_TRY(cml_hdf5_text(&r->file, NULL, info->name, &text, r->err));
        p->value[i] = strcmp(text, info->other) == 0;
        free(text);
    }
    CML_TRY(cml_hdf5_text(&r->file, NULL, "engine", &text, r->err));
    snprintf(p->engine, sizeof p->engine, "%s", text);
    free(text);
    return CML_OK;
}

/* Leaves out empty lines, and `first` lines. */
static void drop_lines(char *text, int first)
{
    char *to = text;
    for (const char *line = text; *line; first--) {
        const size_t length = strcspn(line, "\n"), whole = length + (line[length] == '\n');
        if (first <= 0 && length > 0) {
            memmove(to, line, whole);
            to += whole;
        }
        line += whole;
    }
    *to = '\0';
}

/* What the scene is, by its input, whose first two lines are its name and most often its photons. */
static cml_status read_scene(const struct reader *r)
{
    struct cml_outcome *o = r->o;
    CML_TRY(cml_hdf5_text(&r->file, NULL, "settings", &o->settings, r->err));
    CML_TRY(cml_hdf5_text(&r->file, NULL, "beam", &o->beam, r->err));
    CML_TRY(cml_hdf5_text(&r->file, NULL, "phases", &o->phases, r->err));
    CML_TRY(cml_hdf5_text(&r->file, NULL, "detectors", &o->detectors, r->err));
    CML_TRY(cml_hdf5_text(&r->file, NULL, "boundaries", &o->shapes, r->err));
    CML_TRY(cml_hdf5_text(&r->file, NULL, "input", &o->scene, r->err));
    drop_lines(o->scene, 2);
    return CML_OK;
}

/* ---- all of it ---- */

/* Profiles but A_z, totals and their errors. */
static bool must_be_there(enum cml_quantity quantity, bool errors)
{
    const bool profile = quantity >= CML_QUANTITY_Rd_r && quantity <= CML_QUANTITY_Tt_a;
    return quantity <= CML_QUANTITY_Tt || (profile && !errors);
}

/* Reads a part of a quantity; of detectors all parts or none are there. */
static cml_status read_part(const struct reader *r, enum cml_quantity quantity, int part, bool errors)
{
    double **array = errors ? &r->o->error[quantity] : &r->o->value[quantity], *values;
    const size_t size = cml_outcome_part_size(r->o, quantity);
    char name[CML_OUTCOME_KEY + 4];
    cml_outcome_key(r->o, quantity, part, name);
    if (errors) strcat(name, "_se");
    CML_TRY(cml_h5_numbers(&r->file, name, size, &values, NULL, r->err));
    if (!values && (must_be_there(quantity, errors) || (part > 0 && *array)))
        return cml_fail(r->err, CML_E_INPUT, "%.400s: %.80s has 0 numbers (expected %zu)", r->file.path, name,
                        size);
    if (!values) return CML_OK;
    const cml_status status = cml_outcome_add(r->o, quantity, errors, r->err);
    if (status == CML_OK) memcpy(*array + (size_t)part * size, values, size * sizeof *values);
    free(values);
    return status;
}

static cml_status read_quantity(const struct reader *r, enum cml_quantity quantity, bool errors)
{
    if (!(cml_quantities[quantity].where & CML_IN_H5) || cml_outcome_size(r->o, quantity) == 0) return CML_OK;
    for (int part = 0; part < cml_outcome_parts(r->o, quantity); part++)
        CML_TRY(read_part(r, quantity, part, errors));
    return CML_OK;
}

static cml_status read_head(const struct reader *r)
{
    CML_TRY(read_photons(r));
    CML_TRY(read_options(r));
    return read_scene(r);
}

/* Bodies are counted before what there is of each. */
static cml_status read_all(const struct reader *r)
{
    CML_TRY(read_grid(r));
    CML_TRY(read_head(r));
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        CML_TRY(read_quantity(r, (enum cml_quantity)i, false));
        CML_TRY(read_quantity(r, (enum cml_quantity)i, true));
    }
    r->o->provenance.value[CML_DECIDES_absorption] = r->o->error[CML_QUANTITY_A_z] != NULL;
    return CML_OK;
}

static cml_status read_file(const char *path, cml_status (*read)(const struct reader *),
                            struct cml_outcome *o, struct cml_error *err)
{
    struct reader r = {.o = o, .err = err};
    *o = (struct cml_outcome){.provenance = cml_provenance_unknown()};
    CML_TRY(cml_hdf5_open(path, &r.file, err));
    const cml_status status = read(&r);
    cml_hdf5_close(&r.file);
    if (status != CML_OK) cml_outcome_clear(o);
    return status;
}

cml_status cml_h5_read(const char *path, struct cml_outcome *o, struct cml_error *err)
{
    return read_file(path, read_all, o, err);
}

cml_status cml_h5_read_head(const char *path, struct cml_outcome *o, struct cml_error *err)
{
    return read_file(path, read_head, o, err);
}

#else

cml_status cml_h5_read(const char *path, struct cml_outcome *o, struct cml_error *err)
{
    *o = (struct cml_outcome){0};
    return cml_hdf5_open(path, &(struct cml_hdf5){0}, err);
}

cml_status cml_h5_read_head(const char *path, struct cml_outcome *o, struct cml_error *err)
{
    return cml_h5_read(path, o, err);
}

#endif
