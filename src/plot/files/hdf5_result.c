/* SPDX-License-Identifier: MIT */
#include "plot/files/hdf5_result.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef CML_HDF5
#include <hdf5.h>

enum { MOST_AXES = 3, LAYER_COLUMNS = 5 };

/* A data set in memory. */
struct array {
    int num_axes;
    hsize_t n[MOST_AXES];
    double *value; /* owned, NULL: the file has none of this name */
};

struct reader {
    hid_t file;
    const char *path;
    struct cml_error *err;
};

static size_t size_of(const struct array *array)
{
    size_t size = 1;
    for (int i = 0; i < array->num_axes; i++) size *= (size_t)array->n[i];
    return size;
}

/* ---- the file ---- */

/* The library prints nothing: what failed, our line says. */
static cml_status open_file(const char *path, struct reader *r, struct cml_error *err)
{
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    *r = (struct reader){.file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), .path = path, .err = err};
    if (r->file >= 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%s: cannot be read as an HDF5 file", path);
}

/* Compressed data can promise more than there is memory for; then the request fails here. */
static cml_status read_values(const struct reader *r, const char *name, hid_t dataset, struct array *array)
{
    const size_t size = size_of(array);
    array->value = malloc((size ? size : 1) * sizeof *array->value);
    if (!array->value) return cml_fail_memory(r->err, 8.0 * (double)size, name);
    if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array->value) < 0)
        return cml_fail(r->err, CML_E_INPUT, "%s: %s cannot be read (expected numbers)", r->path, name);
    for (size_t i = 0; i < size; i++)
        if (!isfinite(array->value[i]))
            return cml_fail(r->err, CML_E_INPUT, "%s: %s has %g (expected finite numbers)", r->path, name,
                            array->value[i]);
    return CML_OK;
}

/* The caller frees array->value, which is NULL where the file has no data set of this name. */
static cml_status read_array(const struct reader *r, const char *name, struct array *array)
{
    *array = (struct array){0};
    const hid_t dataset = H5Dopen2(r->file, name, H5P_DEFAULT);
    if (dataset < 0) return CML_OK;
    const hid_t space = H5Dget_space(dataset);
    cml_status status = CML_OK;
    array->num_axes = H5Sget_simple_extent_ndims(space);
    if (array->num_axes < 0 || array->num_axes > MOST_AXES)
        status = cml_fail(r->err, CML_E_INPUT, "%s: %s has %d axes (expected at most %d)", r->path, name,
                          array->num_axes, MOST_AXES);
    else if (array->num_axes > 0)
        (void)H5Sget_simple_extent_dims(space, array->n, NULL);
    if (status == CML_OK) status = read_values(r, name, dataset, array);
    H5Sclose(space);
    H5Dclose(dataset);
    if (status != CML_OK) free(array->value);
    return status;
}

/* Copies a data set of `count` numbers; where the file has none, `out` stays as it is if it may. */
static cml_status read_numbers(const struct reader *r, const char *name, double *out, size_t count,
                               bool may_miss)
{
    struct array array;
    CML_TRY(read_array(r, name, &array));
    const size_t size = array.value ? size_of(&array) : 0;
    if (size == count) memcpy(out, array.value, count * sizeof *out);
    free(array.value);
    if (size == count || (size == 0 && may_miss)) return CML_OK;
    return cml_fail(r->err, CML_E_INPUT, "%s: %s has %zu numbers (expected %zu)", r->path, name, size, count);
}

/* An attribute of the file; 0 where it has none. */
static double read_attribute(const struct reader *r, const char *name)
{
    double number = 0;
    const hid_t attribute = H5Aopen(r->file, name, H5P_DEFAULT);
    if (attribute < 0) return 0;
    if (H5Aread(attribute, H5T_NATIVE_DOUBLE, &number) < 0) number = 0;
    H5Aclose(attribute);
    return number;
}

/* A text of fixed length, as our writer has them, the caller's to free; NULL where there is none. */
static char *read_whole_text(hid_t object, const char *name)
{
    const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
    if (attribute < 0) return NULL;
    const hid_t type = H5Aget_type(attribute), wanted = H5Tcopy(H5T_C_S1);
    const size_t length = H5Tget_size(type);
    bool good = H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0;
    char *whole = good ? calloc(length + 1, 1) : NULL;
    if (whole) {
        (void)H5Tset_size(wanted, length + 1);
        (void)H5Tset_cset(wanted, H5Tget_cset(type));
        good = H5Aread(attribute, wanted, whole) >= 0;
    }
    if (!good) {
        free(whole);
        whole = NULL;
    }
    H5Tclose(wanted);
    H5Tclose(type);
    H5Aclose(attribute);
    return whole;
}

/* The same, cut at `size`; "" where there is none. */
static void read_text(hid_t object, const char *name, char *text, size_t size)
{
    char *whole = read_whole_text(object, name);
    snprintf(text, size, "%s", whole ? whole : "");
    free(whole);
}

/* ---- a result ---- */

/* Number and width of the bins of an axis, whose first middle is half a width; 1 bin where the file has none
 * of this name, which it has not when nothing was tallied over it. */
static cml_status read_axis(const struct reader *r, const char *name, bool may_miss, int *n, double *width)
{
    struct array axis;
    const double most = 1e8;
    CML_TRY(read_array(r, name, &axis));
    *n = axis.value && axis.num_axes == 1 && (double)axis.n[0] <= most ? (int)axis.n[0] : 0;
    *width = *n > 0 ? 2 * axis.value[0] : 0;
    const bool missing = !axis.value;
    free(axis.value);
    if (missing && may_miss) {
        *n = 1;
        *width = 1;
        return CML_OK;
    }
    if (*n > 0 && *width > 0) return CML_OK;
    return cml_fail(r->err, CML_E_INPUT, "%s: no axis %s (expected the .h5 file of a run)", r->path, name);
}

static cml_status read_grid(const struct reader *r, struct cml_mco *mco)
{
    double width;
    CML_TRY(read_axis(r, "r", false, &mco->nr, &mco->dr));
    CML_TRY(read_axis(r, "alpha", false, &mco->na, &width));
    CML_TRY(read_axis(r, "z", true, &mco->nz, &mco->dz));
    CML_TRY(read_axis(r, "layer", false, &mco->num_layers, &width));
    CML_TRY(cml_mco_allocate(mco, r->err));
    char title[1024];
    read_text(r->file, "title", title, sizeof title);
    mco->output = strdup(title);
    if (!mco->output) return cml_fail_memory(r->err, 1, "a name");
    const double photons = read_attribute(r, "photons");
    if (!(photons >= 1 && photons <= 0x1p53))
        return cml_fail(r->err, CML_E_INPUT, "%s: photons = %g (expected a number of 1 or more)", r->path,
                        photons);
    mco->photons = (uint64_t)photons;
    return CML_OK;
}

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
        for (size_t i = 0; i < size_of(&array); i++) fprintf(out, "%.17g\n", array.value[i]);
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
static void write_lines(const struct reader *r, const char *name, const char *prefix, int first, FILE *out)
{
    char *text = read_whole_text(r->file, name);
    int number = 0;
    for (const char *line = text; line && *line; number++) {
        const size_t length = strcspn(line, "\n");
        if (number >= first && length > 0) fprintf(out, "%s%.*s\n", prefix, (int)length, line);
        line += length + (line[length] == '\n');
    }
    free(text);
}

/* Whose random numbers it has, and what the scene is: of a run by its input, whose first two lines are its
 * name and most often its photons; of a merged result by what that says itself. */
static void write_origin(const struct reader *r, FILE *out)
{
    char merged[2];
    read_text(r->file, "merged", merged, sizeof merged);
    if (merged[0])
        write_lines(r, "merged", "# ", 0, out);
    else
        fprintf(out, "# engine -, seed %.0f, run %.0f\n", read_attribute(r, "seed"),
                read_attribute(r, "run"));
    if (H5Aexists(r->file, "reentry") > 0 && read_attribute(r, "reentry") == 0)
        fprintf(out, "# %s\n", CML_MCO_FIRST_EXIT);
    write_lines(r, "settings", "# set ", 0, out);
    write_lines(r, "beam", "# ", 0, out);
    write_lines(r, "boundaries", "# ", 0, out);
    write_lines(r, "input", "# scene ", 2, out);
    write_lines(r, "scene", "# scene ", 0, out);
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
    read_text(r->file, "sampling", sampling, sizeof sampling);
    write_origin(r, out);
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
    struct reader r;
    *mco = (struct cml_mco){0};
    CML_TRY(open_file(path, &r, err));
    cml_status status = read_grid(&r, mco);
    if (status == CML_OK) status = read_layers(&r, mco);
    if (status == CML_OK) status = read_values_of_result(&r, mco);
    if (status == CML_OK) status = read_extra(&r, mco);
    H5Fclose(r.file);
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
    return cml_fail(r->err, CML_E_INPUT, "%s: %s has a step of %g (expected one of 1e-12..1e12)", r->path,
                    name, *width);
}

static cml_status fill_map(const struct reader *r, const char *name, const struct array *array,
                           struct cml_pixels *map)
{
    if (!array->value || array->num_axes != 2 || size_of(array) == 0)
        return cml_fail(r->err, CML_E_INPUT, "%s: no map %.80s (expected a data set over y and x)", r->path,
                        name);
    const size_t n[2] = {(size_t)array->n[1], (size_t)array->n[0]};
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
                            "%s: %s of pixel %zu %zu = %g (expected a number of 0 or more)", r->path, name,
                            i % n[0], i / n[0], array->value[i]);
    }
    return CML_OK;
}

cml_status cml_hdf5_read_map(const char *path, const char *name, struct cml_pixels *map,
                             char unit[CML_HDF5_UNIT], struct cml_error *err)
{
    struct reader r;
    struct array array;
    *map = (struct cml_pixels){0};
    unit[0] = '\0';
    CML_TRY(open_file(path, &r, err));
    cml_status status = read_array(&r, name, &array);
    if (status == CML_OK) {
        status = fill_map(&r, name, &array, map);
        free(array.value);
    }
    const hid_t dataset = H5Dopen2(r.file, name, H5P_DEFAULT);
    if (dataset >= 0) {
        read_text(dataset, "units", unit, CML_HDF5_UNIT);
        H5Dclose(dataset);
    }
    H5Fclose(r.file);
    if (status != CML_OK) cml_pixels_clear(map);
    return status;
}

#else

static cml_status refuse(const char *path, struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "%s: this program was built without HDF5", path);
}

cml_status cml_hdf5_read_result(const char *path, struct cml_mco *mco, struct cml_error *err)
{
    *mco = (struct cml_mco){0};
    return refuse(path, err);
}

cml_status cml_hdf5_read_map(const char *path, const char *name, struct cml_pixels *map,
                             char unit[CML_HDF5_UNIT], struct cml_error *err)
{
    (void)name;
    *map = (struct cml_pixels){0};
    unit[0] = '\0';
    return refuse(path, err);
}

#endif
