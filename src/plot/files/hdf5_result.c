/* SPDX-License-Identifier: MIT */
#include "plot/files/hdf5_result.h"

#include "output/files/hdf5_read.h"
#include "output/files/result_names.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef CML_HDF5

/* A data set in memory. */
struct array {
    int num_axes;
    size_t n[CML_FIELD_AXES], size;
    double *value; /* owned, NULL: the file has none of this name */
};

struct reader {
    struct cml_hdf5 file;
    struct cml_error *err;
};

/* ---- the file ---- */

/* Errors may be unknown, of one packet: NaN. */
static cml_status read_values(const struct reader *r, const struct cml_hdf5_dataset *dataset, double *out)
{
    const bool errors = cml_result_is_errors(dataset->name);
    CML_TRY(cml_hdf5_values(dataset, 0, dataset->size, out, r->err));
    for (size_t i = 0; i < dataset->size; i++)
        if (!isfinite(out[i]) && !(errors && isnan(out[i])))
            return cml_fail(r->err, CML_E_INPUT, "%.400s: %s[%zu] = %g (expected a finite number)",
                            r->file.path, dataset->name, i, out[i]);
    return CML_OK;
}

/* The caller frees array->value, which is NULL where the file has no data set of this name. */
static cml_status read_array(const struct reader *r, const char *name, struct array *array)
{
    struct cml_hdf5_dataset dataset;
    *array = (struct array){0};
    CML_TRY(cml_hdf5_dataset_open(&r->file, name, &dataset, r->err));
    if (dataset.id == 0) return CML_OK;
    array->num_axes = dataset.num_axes;
    array->size = dataset.size;
    memcpy(array->n, dataset.n, sizeof array->n);
    array->value = malloc(dataset.size * sizeof *array->value);
    const cml_status status = array->value ? read_values(r, &dataset, array->value)
                                           : cml_fail_memory(r->err, 8.0 * (double)dataset.size, name);
    cml_hdf5_dataset_close(&dataset);
    if (status != CML_OK) free(array->value);
    return status;
}

/* A data set of `count` numbers; where the file has none, `out` stays as it is if it may. */
static cml_status read_numbers(const struct reader *r, const char *name, double *out, size_t count,
                               bool may_miss)
{
    struct cml_hdf5_dataset dataset;
    CML_TRY(cml_hdf5_dataset_open(&r->file, name, &dataset, r->err));
    if (dataset.id == 0 && may_miss) return CML_OK;
    const cml_status status =
        dataset.size == count ? read_values(r, &dataset, out)
                              : cml_fail(r->err, CML_E_INPUT, "%.400s: %.80s has %zu numbers (expected %zu)",
                                         r->file.path, name, dataset.size, count);
    cml_hdf5_dataset_close(&dataset);
    return status;
}

/* An attribute of the file, cut at `size`; "" where there is none. */
static cml_status read_text(const struct reader *r, const char *name, char *text, size_t size)
{
    char *whole;
    CML_TRY(cml_hdf5_text(&r->file, NULL, name, &whole, r->err));
    snprintf(text, size, "%s", whole);
    free(whole);
    return CML_OK;
}

/* ---- a result ---- */

/* Number and width of the bins of an axis, whose first middle is half a width; 1 bin where the file has none
 * of this name, which it has not when nothing was tallied over it. */
static cml_status read_axis(const struct reader *r, const char *name, bool may_miss, int *n, double *width)
{
    struct array axis;
    const size_t most = 100000000;
    CML_TRY(read_array(r, name, &axis));
    *n = axis.value && axis.num_axes == 1 && axis.size <= most ? (int)axis.size : 0;
    *width = *n > 0 ? 2 * axis.value[0] : 0;
    const bool missing = !axis.value;
    free(axis.value);
    if (missing && may_miss) {
        *n = 1;
        *width = 1;
        return CML_OK;
    }
    if (*n > 0 && *width > 0) return CML_OK;
    return cml_fail(r->err, CML_E_INPUT, "%.400s: no axis %s (expected the .h5 file of a run)", r->file.path,
                    name);
}

static cml_status read_grid(const struct reader *r, struct cml_mco *mco)
{
    double width;
    CML_TRY(read_axis(r, "r", false, &mco->nr, &mco->dr));
    CML_TRY(read_axis(r, "alpha", false, &mco->na, &width));
    CML_TRY(read_axis(r, "z", true, &mco->nz, &mco->dz));
    CML_TRY(read_axis(r, "layer", false, &mco->num_layers, &width));
    const double nz = mco->nz, nr = mco->nr, na = mco->na, most = (double)cml_hdf5_most_numbers(&r->file);
    if (nr * nz + 2 * nr * na + 6.0 * mco->num_layers > most)
        return cml_fail(
            r->err, CML_E_INPUT,
            "%.400s: nz nr na = %g %g %g (expected no more than the %.0f numbers the file can hold)",
            r->file.path, nz, nr, na, most);
    return cml_mco_allocate(mco, r->err);
}

static cml_status read_head(const struct reader *r, struct cml_mco *mco)
{
    double photons = 0;
    CML_TRY(cml_hdf5_text(&r->file, NULL, "title", &mco->output, r->err));
    CML_TRY(cml_hdf5_number(&r->file, "photons", &photons, r->err));
    if (!(photons >= 1 && photons <= 0x1p53 && photons == floor(photons)))
        return cml_fail(r->err, CML_E_INPUT, "%.400s: photons = %g (expected a whole number of 1 or more)",
                        r->file.path, photons);
    mco->photons = (uint64_t)photons;
    return CML_OK;
}

enum { LAYER_COLUMNS = 5 };

/* Older files have no media. */
static cml_status read_layers(const struct reader *r, struct cml_mco *mco)
{
    static const char *const names[LAYER_COLUMNS] = {"layer_n", "layer_mua", "layer_mus", "layer_g",
                                                     "layer_d"};
    const size_t count = (size_t)mco->num_layers;
    double *column = calloc(count, sizeof *column);
    if (!column) return cml_fail_memory(r->err, 8.0 * (double)count, "the layers");
    cml_status status = CML_OK;
    for (int i = 0; i < LAYER_COLUMNS && status == CML_OK; i++) {
        memset(column, 0, count * sizeof *column);
        status = read_numbers(r, names[i], column, count, true);
        for (size_t l = 0; l < count; l++) mco->layer[l][i] = column[l];
    }
    free(column);
    return status;
}

static cml_status read_values_of_result(const struct reader *r, struct cml_mco *mco)
{
    const size_t nr = (size_t)mco->nr, nz = (size_t)mco->nz, na = (size_t)mco->na;
    const struct {
        const char *name;
        double *out;
        size_t count;
        bool may_miss;
    } arrays[] = {
        {"Rsp", &mco->Rsp, 1, false},
        {"Rd", &mco->Rd, 1, false},
        {"A", &mco->A, 1, false},
        {"Tt", &mco->Tt, 1, false},
        {"A_l", mco->A_l, (size_t)mco->num_layers, true},
        {"A_z", mco->A_z, nz, true},
        {"Rd_r", mco->Rd_r, nr, false},
        {"Rd_a", mco->Rd_a, na, false},
        {"Tt_r", mco->Tt_r, nr, false},
        {"Tt_a", mco->Tt_a, na, false},
        {"A_rz", mco->A_rz, nr * nz, true},
        {"Rd_ra", mco->Rd_ra, nr * na, true},
        {"Tt_ra", mco->Tt_ra, nr * na, true},
    };
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        CML_TRY(read_numbers(r, arrays[i].name, arrays[i].out, arrays[i].count, arrays[i].may_miss));
    return CML_OK;
}

/* A section of `extra` with the numbers of a data set; nothing where the file has none of this name. */
static cml_status write_section(const struct reader *r, const char *key, const char *dataset, FILE *out)
{
    struct array array;
    CML_TRY(read_array(r, dataset, &array));
    if (array.value) {
        fprintf(out, "\n%s # from %s\n", key, dataset);
        for (size_t i = 0; i < array.size; i++) fprintf(out, "%.17g\n", array.value[i]);
    }
    free(array.value);
    return CML_OK;
}

/* The standard errors of one profile. */
static cml_status write_errors(const struct reader *r, const char *name, FILE *out)
{
    char key[32], dataset[32];
    snprintf(key, sizeof key, "se_%s", name);
    snprintf(dataset, sizeof dataset, "%s_se", name);
    return write_section(r, key, dataset, out);
}

/* Every line of a text attribute behind the prefix; those from number `first` on. */
static cml_status write_lines(const struct reader *r, const char *name, const char *prefix, int first,
                              FILE *out)
{
    char *text;
    int number = 0;
    CML_TRY(cml_hdf5_text(&r->file, NULL, name, &text, r->err));
    for (const char *line = text; *line; number++) {
        const size_t length = strcspn(line, "\n");
        if (number >= first && length > 0) fprintf(out, "%s%.*s\n", prefix, (int)length, line);
        line += length + (line[length] == '\n');
    }
    free(text);
    return CML_OK;
}

/* Whose random numbers a run has; a merged result says so itself. */
static cml_status write_seed(const struct reader *r, FILE *out)
{
    double seed = 0, run = 0;
    CML_TRY(cml_hdf5_number(&r->file, "seed", &seed, r->err));
    CML_TRY(cml_hdf5_number(&r->file, "run", &run, r->err));
    fprintf(out, "# engine -, seed %.0f, run %.0f\n", seed, run);
    return CML_OK;
}

/* Whose random numbers it has, and what the scene is: of a run by its input, whose first two lines are its
 * name and most often its photons; of a merged result by what that says itself. */
static cml_status write_origin(const struct reader *r, FILE *out)
{
    char merged[2];
    double reentry = 1;
    CML_TRY(read_text(r, "merged", merged, sizeof merged));
    CML_TRY(merged[0] ? write_lines(r, "merged", "# ", 0, out) : write_seed(r, out));
    CML_TRY(cml_hdf5_number(&r->file, "reentry", &reentry, r->err));
    if (reentry == 0) fprintf(out, "# %s\n", CML_MCO_FIRST_EXIT);
    CML_TRY(write_lines(r, "settings", "# set ", 0, out));
    CML_TRY(write_lines(r, "beam", "# ", 0, out));
    CML_TRY(write_lines(r, "boundaries", "# ", 0, out));
    CML_TRY(write_lines(r, "input", "# scene ", 2, out));
    return write_lines(r, "scene", "# scene ", 0, out);
}

/* Sections books, residue and lost. */
static cml_status write_books(const struct reader *r, FILE *out)
{
    static const char *const names[] = {"book_launched",   "book_gained",      "book_specular",
                                        "book_reflected",  "book_transmitted", "book_absorbed",
                                        "book_roulette",   "book_trapped",     "book_lost",
                                        "book_overflow_r", "book_overflow_z",  "book_above"};
    enum { BOOKS = sizeof names / sizeof *names };
    double books[BOOKS] = {0}, residue = 0, lost = 0;
    for (int i = 0; i < BOOKS; i++) CML_TRY(read_numbers(r, names[i], &books[i], 1, true));
    CML_TRY(read_numbers(r, "residue", &residue, 1, true));
    CML_TRY(read_numbers(r, "lost", &lost, 1, true));
    fputs("\nbooks #\n", out);
    for (int i = 0; i < BOOKS; i++) fprintf(out, "%.17g\n", books[i]);
    fprintf(out, "\nresidue #\n%.17g\n\nlost #\n%.17g\n", residue, lost);
    return CML_OK;
}

/* What an .mco file has behind MCML's sections, as far as pictures and comparisons read it. */
static cml_status write_extra(const struct reader *r, FILE *out)
{
    static const char *const totals[] = {"Rsp_se", "Rd_se", "A_se", "Tt_se"};
    static const char *const profiles[] = {"A_z", "Rd_r", "Rd_a", "Tt_r", "Tt_a"};
    char sampling[16];
    double error[4];
    CML_TRY(read_text(r, "sampling", sampling, sizeof sampling));
    CML_TRY(write_origin(r, out));
    fprintf(out, "\nlattice #\n%d\n", strcmp(sampling, "lattice") == 0);
    fputs("\nse_RAT #\n", out);
    for (int i = 0; i < 4; i++) {
        CML_TRY(read_numbers(r, totals[i], &error[i], 1, false));
        fprintf(out, "%.17g\n", error[i]);
    }
    for (size_t i = 0; i < sizeof profiles / sizeof *profiles; i++)
        CML_TRY(write_errors(r, profiles[i], out));
    CML_TRY(write_section(r, "A_body", "A_body", out));
    return write_books(r, out);
}

static cml_status read_extra(const struct reader *r, struct cml_mco *mco)
{
    size_t size = 0;
    FILE *out = open_memstream(&mco->extra, &size);
    if (!out) return cml_fail_memory(r->err, 1, "a result");
    cml_status status = write_extra(r, out);
    const int failed = ferror(out);
    if ((fclose(out) != 0 || failed) && status == CML_OK)
        status = cml_fail_memory(r->err, (double)size, "a result");
    return status;
}

cml_status cml_hdf5_read_result(const char *path, struct cml_mco *mco, struct cml_error *err)
{
    struct reader r = {.err = err};
    *mco = (struct cml_mco){0};
    CML_TRY(cml_hdf5_open(path, &r.file, err));
    cml_status status = read_grid(&r, mco);
    if (status == CML_OK) status = read_head(&r, mco);
    if (status == CML_OK) status = read_layers(&r, mco);
    if (status == CML_OK) status = read_values_of_result(&r, mco);
    if (status == CML_OK) status = read_extra(&r, mco);
    cml_hdf5_close(&r.file);
    if (status != CML_OK) cml_mco_clear(mco);
    return status;
}

/* ---- a map ---- */

/* Corner and width of the pixels from their middles. The middle of a single one lies at 0; *width stays. */
static cml_status read_pixel_axis(const struct reader *r, const char *name, size_t n, double *origin,
                                  double *width)
{
    double *middle = calloc(n, sizeof *middle);
    if (!middle) return cml_fail_memory(r->err, 8.0 * (double)n, "a map");
    const cml_status status = read_numbers(r, name, middle, n, false);
    if (n > 1) *width = (middle[n - 1] - middle[0]) / (double)(n - 1);
    *origin = middle[0] - *width / 2;
    free(middle);
    if (status != CML_OK || (*width >= 1e-12 && *width <= 1e12)) return status;
    return cml_fail(r->err, CML_E_INPUT, "%.400s: %s has a step of %g (expected one of 1e-12..1e12)",
                    r->file.path, name, *width);
}

static cml_status fill_map(const struct reader *r, const char *name, const struct array *array,
                           struct cml_pixels *map)
{
    if (!array->value || array->num_axes != 2)
        return cml_fail(r->err, CML_E_INPUT, "%.400s: no map %.80s (expected a data set over y and x)",
                        r->file.path, name);
    const size_t n[2] = {array->n[1], array->n[0]};
    *map = (struct cml_pixels){.n = {n[0], n[1]}, .spacing = {1, 1}};
    CML_TRY(read_pixel_axis(r, "x", n[0], &map->origin[0], &map->spacing[0]));
    if (n[1] == 1) map->spacing[1] = map->spacing[0];
    CML_TRY(read_pixel_axis(r, "y", n[1], &map->origin[1], &map->spacing[1]));
    map->value = malloc(n[0] * n[1] * sizeof *map->value);
    if (!map->value) return cml_fail_memory(r->err, 4.0 * (double)(n[0] * n[1]), "a map");
    for (size_t i = 0; i < n[0] * n[1]; i++) {
        map->value[i] = (float)array->value[i];
        if (!(array->value[i] >= 0 && array->value[i] <= 1e30))
            return cml_fail(r->err, CML_E_INPUT,
                            "%.400s: %.80s of pixel %zu %zu = %g (expected a number of 0 or more)",
                            r->file.path, name, i % n[0], i / n[0], array->value[i]);
    }
    return CML_OK;
}

static cml_status read_unit(const struct reader *r, const char *name, char unit[CML_HDF5_UNIT])
{
    struct cml_hdf5_dataset dataset;
    char *text;
    CML_TRY(cml_hdf5_dataset_open(&r->file, name, &dataset, r->err));
    const cml_status status = cml_hdf5_text(&r->file, &dataset, "units", &text, r->err);
    cml_hdf5_dataset_close(&dataset);
    if (status != CML_OK) return status;
    snprintf(unit, CML_HDF5_UNIT, "%s", text);
    free(text);
    return CML_OK;
}

cml_status cml_hdf5_read_map(const char *path, const char *name, struct cml_pixels *map,
                             char unit[CML_HDF5_UNIT], struct cml_error *err)
{
    struct reader r = {.err = err};
    struct array array;
    *map = (struct cml_pixels){0};
    unit[0] = '\0';
    CML_TRY(cml_hdf5_open(path, &r.file, err));
    cml_status status = read_array(&r, name, &array);
    if (status == CML_OK) {
        status = fill_map(&r, name, &array, map);
        free(array.value);
    }
    if (status == CML_OK) status = read_unit(&r, name, unit);
    cml_hdf5_close(&r.file);
    if (status != CML_OK) cml_pixels_clear(map);
    return status;
}

#else

cml_status cml_hdf5_read_result(const char *path, struct cml_mco *mco, struct cml_error *err)
{
    *mco = (struct cml_mco){0};
    return cml_hdf5_open(path, &(struct cml_hdf5){0}, err);
}

cml_status cml_hdf5_read_map(const char *path, const char *name, struct cml_pixels *map,
                             char unit[CML_HDF5_UNIT], struct cml_error *err)
{
    (void)name;
    *map = (struct cml_pixels){0};
    unit[0] = '\0';
    return cml_hdf5_open(path, &(struct cml_hdf5){0}, err);
}

#endif
