/* SPDX-License-Identifier: MIT */
#include "output/files/hdf5_file.h"

#include "base/atomic_file.h"

#include <stdlib.h>
#include <string.h>

#ifdef CML_HDF5
#include <hdf5.h>
#include <hdf5_hl.h>

#define CHUNK ((size_t)1 << 17)  /* values: what is there as doubles at a time */
#define GROWTH ((size_t)1 << 20) /* bytes by which the file grows in memory */
#define NOWHERE "/dev/null/none" /* HDF5 tries to open a file of the name first: there can be none */

/* The file is made in memory, where nothing but memory can fail, and is written like all other files: HDF5
 * keeps what it cannot write, says so at some later call, and writes other bytes then. The library's calls
 * return a negative number when they fail. The first failure is remembered, and the calls after it fail too,
 * or do nothing, on the invalid handles that it left: so code runs straight on, and looks once at the end. */
struct writer {
    hid_t file;
    bool failed;
    double *buffer;       /* [CHUNK] */
    float *narrow;        /* [CHUNK] the same in single precision */
    unsigned char *image; /* the file's bytes, which stay when the library closes it */
    size_t size, room;    /* bytes of it; that there is memory for */
    size_t refused;       /* bytes that there was no memory for; 0: none */
};

static void check(struct writer *w, int64_t returned)
{
    if (returned < 0) w->failed = true;
}

static hid_t made(struct writer *w, hid_t handle)
{
    check(w, handle);
    return handle;
}

/* Attributes of the file or of a data set. UTF-8, because names of files may be. */
static void put_text(struct writer *w, hid_t object, const char *name, const char *text)
{
    const hid_t type = made(w, H5Tcopy(H5T_C_S1)), space = made(w, H5Screate(H5S_SCALAR));
    check(w, H5Tset_size(type, strlen(text) + 1));
    check(w, H5Tset_cset(type, H5T_CSET_UTF8));
    const hid_t attribute = made(w, H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT));
    check(w, H5Awrite(attribute, type, text));
    check(w, H5Aclose(attribute));
    check(w, H5Sclose(space));
    check(w, H5Tclose(type));
}

/* Numbers are doubles throughout: 2^53 is enough for seeds and photons, and every reader has them. */
static void put_number(struct writer *w, hid_t object, const char *name, double number)
{
    const hid_t space = made(w, H5Screate(H5S_SCALAR));
    const hid_t attribute =
        made(w, H5Acreate2(object, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT));
    check(w, H5Awrite(attribute, H5T_NATIVE_DOUBLE, &number));
    check(w, H5Aclose(attribute));
    check(w, H5Sclose(space));
}

/* The last axes whole, as far as they fit into a chunk, then part of one axis: so a chunk holds successive
 * values, and is written, filtered and forgotten at once. */
static void choose_chunk(const struct cml_field *field, hsize_t *chunk)
{
    size_t room = CHUNK;
    for (int i = field->num_axes - 1; i >= 0; i--) {
        chunk[i] = field->axis[i]->n < room ? field->axis[i]->n : room;
        if (chunk[i] == 0) chunk[i] = 1; /* an empty array has none */
        room = chunk[i] < field->axis[i]->n ? 1 : room / (size_t)chunk[i];
    }
}

/* Creates a data set without times, so that the same fields give the same bytes. Shuffled (all first bytes,
 * all second bytes, ...) before deflate, which then finds what neighbouring numbers have in common; at level
 * 1, the fastest. A single number stands in the header of its data set, which has a checksum. */
static hid_t create_dataset(struct writer *w, const struct cml_field *field, const hsize_t *chunk)
{
    hsize_t size[CML_FIELD_AXES];
    for (int i = 0; i < field->num_axes; i++) size[i] = field->axis[i]->n;
    const hid_t space =
        made(w, field->num_axes ? H5Screate_simple(field->num_axes, size, NULL) : H5Screate(H5S_SCALAR));
    const hid_t properties = made(w, H5Pcreate(H5P_DATASET_CREATE));
    check(w, H5Pset_obj_track_times(properties, false));
    if (field->plain) check(w, H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER)); /* all is written */
    if (field->num_axes == 0) check(w, H5Pset_layout(properties, H5D_COMPACT));
    if (cml_field_size(field) > 0 && field->num_axes > 0 && !field->plain) { /* chunks are not empty */
        check(w, H5Pset_chunk(properties, field->num_axes, chunk));
        check(w, H5Pset_shuffle(properties));
        check(w, H5Pset_deflate(properties, 1));
    }
    const hid_t type = field->single ? H5T_IEEE_F32LE : H5T_IEEE_F64LE;
    const hid_t dataset =
        made(w, H5Dcreate2(w->file, field->name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT));
    check(w, H5Pclose(properties));
    check(w, H5Sclose(space));
    return dataset;
}

/* Returns where they are: rounded here, which is quicker than the library. */
static const void *get_values(struct writer *w, const struct cml_field *field, size_t begin, size_t count)
{
    field->values(field->context, begin, count, w->buffer);
    if (field->broken && *field->broken) w->failed = true;
    if (!field->single) return w->buffer;
    for (size_t i = 0; i < count; i++) w->narrow[i] = (float)w->buffer[i];
    return w->narrow;
}

static hid_t type_here(const struct cml_field *field)
{
    return field->single ? H5T_NATIVE_FLOAT : H5T_NATIVE_DOUBLE;
}

/* One chunk, cut off at the end of the array. Returns how many values that was. */
static size_t write_chunk(struct writer *w, hid_t dataset, const struct cml_field *field,
                          const hsize_t *start, const hsize_t *chunk, size_t begin)
{
    hsize_t size[CML_FIELD_AXES];
    size_t count = 1;
    for (int i = 0; i < field->num_axes; i++) {
        const hsize_t left = field->axis[i]->n - start[i];
        size[i] = left < chunk[i] ? left : chunk[i];
        count *= (size_t)size[i];
    }
    const void *values = get_values(w, field, begin, count);
    const hid_t there = made(w, H5Dget_space(dataset));
    const hid_t here = made(w, H5Screate_simple(field->num_axes, size, NULL));
    check(w, H5Sselect_hyperslab(there, H5S_SELECT_SET, start, NULL, size, NULL));
    check(w, H5Dwrite(dataset, type_here(field), here, there, H5P_DEFAULT, values));
    check(w, H5Sclose(here));
    check(w, H5Sclose(there));
    return count;
}

/* Chunk after chunk, each filled when it is written: a volume of 1e9 voxels is never in memory as doubles.
 * Once a call has failed nothing more is tried. */
static void write_values(struct writer *w, hid_t dataset, const struct cml_field *field, const hsize_t *chunk)
{
    hsize_t start[CML_FIELD_AXES] = {0};
    for (size_t begin = 0; !w->failed && begin < cml_field_size(field);) {
        begin += write_chunk(w, dataset, field, start, chunk, begin);
        int axis = field->num_axes - 1;
        for (; axis >= 0; axis--) { /* the next chunk, like an odometer */
            start[axis] += chunk[axis];
            if (start[axis] < field->axis[axis]->n) break;
            start[axis] = 0;
        }
    }
}

/* Bin middles, computed from their numbers and not summed, so that errors do not add up. */
static void axis_values(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_axis *axis = context;
    for (size_t i = begin; i < begin + count; i++)
        *out++ = axis->values ? axis->values[i] : axis->first + (double)i * axis->step;
}

/* Names of attributes as in the CF conventions, which xarray shows and plots with. */
static void describe(struct writer *w, hid_t dataset, const struct cml_field *field)
{
    put_text(w, dataset, "long_name", field->long_name);
    put_text(w, dataset, "units", field->units);
    if (field->errors) put_text(w, dataset, "ancillary_variables", field->errors);
}

/* Writes a field without axes, which has no chunks. */
static void write_scalar(struct writer *w, hid_t dataset, const struct cml_field *field)
{
    const void *values = get_values(w, field, 0, 1);
    check(w, H5Dwrite(dataset, type_here(field), H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
}

/* After a failure the data set is returned all the same: the caller closes it. */
static hid_t write_dataset(struct writer *w, const struct cml_field *field)
{
    hsize_t chunk[CML_FIELD_AXES] = {1};
    choose_chunk(field, chunk);
    const hid_t dataset = create_dataset(w, field, chunk);
    if (w->failed) return dataset;
    describe(w, dataset, field);
    if (field->num_axes)
        write_values(w, dataset, field, chunk);
    else
        write_scalar(w, dataset, field);
    return dataset;
}

/* The axis as a dimension scale, opened; made when no field before needed it. */
static hid_t open_axis(struct writer *w, const struct cml_axis *axis)
{
    const htri_t there = H5Lexists(w->file, axis->name, H5P_DEFAULT);
    check(w, there);
    if (there > 0) return made(w, H5Dopen2(w->file, axis->name, H5P_DEFAULT));
    struct cml_field field = {.long_name = axis->long_name,
                              .units = axis->units,
                              .num_axes = 1,
                              .axis = {axis},
                              .values = axis_values,
                              .context = axis};
    strncpy(field.name, axis->name, sizeof field.name - 1);
    const hid_t dataset = write_dataset(w, &field);
    check(w, H5DSset_scale(dataset, axis->name));
    return dataset;
}

static bool is_axis(const struct cml_field *field)
{
    return field->num_axes == 1 && strcmp(field->name, field->axis[0]->name) == 0;
}

/* Axes are attached as dimension scales, which xarray and MATLAB take for coordinates. */
static void write_field(struct writer *w, const struct cml_field *field)
{
    const hid_t dataset = is_axis(field) ? open_axis(w, field->axis[0]) : write_dataset(w, field);
    for (int i = 0; i < field->num_axes && !is_axis(field) && !w->failed; i++) {
        const hid_t scale = open_axis(w, field->axis[i]);
        check(w, H5DSattach_scale(dataset, scale, (unsigned)i));
        check(w, H5Dclose(scale));
    }
    check(w, H5Dclose(dataset));
}

/* Contiguous data, unlike an attribute, stand in the file without a checksum that would differ, too. */
static void write_call_text(struct writer *w, hid_t group, const char *name, const char *long_name,
                            const char *text)
{
    char *padded = (char *)w->buffer;
    const size_t length = strnlen(text, CML_HDF5_CALL - 1);
    memset(padded, 0, CML_HDF5_CALL);
    memcpy(padded, text, length);
    const hid_t type = made(w, H5Tcopy(H5T_C_S1)), space = made(w, H5Screate(H5S_SCALAR));
    const hid_t properties = made(w, H5Pcreate(H5P_DATASET_CREATE));
    check(w, H5Tset_size(type, CML_HDF5_CALL));
    check(w, H5Tset_cset(type, H5T_CSET_UTF8));
    check(w, H5Pset_obj_track_times(properties, false));
    const hid_t dataset = made(w, H5Dcreate2(group, name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT));
    put_text(w, dataset, "long_name", long_name);
    check(w, H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, padded));
    check(w, H5Dclose(dataset));
    check(w, H5Pclose(properties));
    check(w, H5Sclose(space));
    check(w, H5Tclose(type));
}

static void write_call(struct writer *w, const struct cml_hdf5_call *call)
{
    const hid_t properties = made(w, H5Pcreate(H5P_GROUP_CREATE));
    check(w, H5Pset_obj_track_times(properties, false));
    const hid_t group = made(w, H5Gcreate2(w->file, "call", H5P_DEFAULT, properties, H5P_DEFAULT));
    write_call_text(w, group, "command", "command line", call->command);
    write_call_text(w, group, "input_file", "input file as it was named there", call->input_file);
    check(w, H5Gclose(group));
    check(w, H5Pclose(properties));
}

static void write_all(struct writer *w, const struct cml_attribute *attributes, int num_attributes,
                      const struct cml_hdf5_call *call, const struct cml_field *fields, int num_fields)
{
    for (int i = 0; i < num_attributes && !w->failed; i++) {
        if (attributes[i].value)
            put_text(w, w->file, attributes[i].name, attributes[i].value);
        else
            put_number(w, w->file, attributes[i].name, attributes[i].number);
    }
    if (!w->failed) write_call(w, call);
    for (int i = 0; i < num_fields && !w->failed; i++) write_field(w, &fields[i]);
}

bool cml_hdf5_available(void)
{
    return true;
}

/* What the driver calls in place of realloc, free, and copies of what they are told. */
static void *grow_image(void *old, size_t size, H5FD_file_image_op_t why, void *writer)
{
    struct writer *w = writer;
    (void)why;
    unsigned char *larger = realloc(old, size);
    if (!larger) {
        w->refused = size;
        return NULL;
    }
    if (size > w->room) memset(larger + w->room, 0, size - w->room); /* the library writes not all of it */
    w->image = larger;
    w->room = size;
    return larger;
}

static herr_t keep_image(void *image, H5FD_file_image_op_t why, void *writer)
{
    (void)image, (void)why, (void)writer;
    return 0;
}

static void *same_writer(void *writer)
{
    return writer;
}

static herr_t keep_writer(void *writer)
{
    (void)writer;
    return 0;
}

/* The format of HDF5 1.8, where an attribute (the input text) may be longer than 64 KiB. */
static void create_file(struct writer *w)
{
    H5FD_file_image_callbacks_t calls = {.image_realloc = grow_image,
                                         .image_free = keep_image,
                                         .udata_copy = same_writer,
                                         .udata_free = keep_writer,
                                         .udata = w};
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const hid_t access = made(w, H5Pcreate(H5P_FILE_ACCESS)), root = made(w, H5Pcreate(H5P_FILE_CREATE));
    check(w, H5Pset_obj_track_times(root, false));
    check(w, H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18));
    check(w, H5Pset_fapl_core(access, GROWTH, false));
    check(w, H5Pset_file_image_callbacks(access, &calls));
    w->file = made(w, H5Fcreate(NOWHERE, H5F_ACC_TRUNC, root, access));
    check(w, H5Pclose(root));
    check(w, H5Pclose(access));
}

/* The address of the file's end in its superblock, version 2 as all files of HDF5 1.8 have it (HDF5 File
 * Format Specification, II.A). 0: it is not closed. */
static size_t end_of_file(const struct writer *w)
{
    enum { VERSION = 8, OFFSETS = 9, WRITERS = 11, END = 28, SIZE = 48 };
    uint64_t end = 0;
    if (w->room < SIZE || w->image[VERSION] != 2 || w->image[OFFSETS] != sizeof end || w->image[WRITERS] != 0)
        return 0;
    for (size_t i = sizeof end; i > 0; i--) end = end << 8 | w->image[END + i - 1];
    return end <= w->room ? (size_t)end : 0;
}

/* Only then it says where it ends, and that nobody writes to it any more. */
static void close_file(struct writer *w)
{
    check(w, H5Fclose(w->file));
    w->size = end_of_file(w);
    if (w->size == 0) w->failed = true;
}

static cml_status publish(const char *path, const struct writer *w, struct cml_error *err)
{
    struct cml_file file;
    if (w->refused > 0) return cml_fail_memory(err, (double)w->refused, "an HDF5 file");
    if (w->failed)
        return cml_fail(err, CML_E_IO, "%s: cannot be written (HDF5 failed: is there too little memory?)",
                        path);
    CML_TRY(cml_file_create(path, &file, err));
    fwrite(w->image, 1, w->size, file.stream);
    return cml_file_commit(&file, err);
}

cml_status cml_hdf5_write(const char *path, const struct cml_attribute *attributes, int num_attributes,
                          const struct cml_hdf5_call *call, const struct cml_field *fields, int num_fields,
                          struct cml_error *err)
{
    const size_t size = CHUNK * (sizeof(double) + sizeof(float));
    struct writer w = {.buffer = malloc(size)};
    if (!w.buffer) return cml_fail_memory(err, (double)size, "an HDF5 file");
    w.narrow = (float *)(w.buffer + CHUNK);
    create_file(&w);
    write_all(&w, attributes, num_attributes, call, fields, num_fields);
    close_file(&w);
    free(w.buffer);
    const cml_status status = publish(path, &w, err);
    free(w.image);
    return status;
}

#else

bool cml_hdf5_available(void)
{
    return false;
}

cml_status cml_hdf5_write(const char *path, const struct cml_attribute *attributes, int num_attributes,
                          const struct cml_hdf5_call *call, const struct cml_field *fields, int num_fields,
                          struct cml_error *err)
{
    (void)attributes, (void)num_attributes, (void)call, (void)fields, (void)num_fields;
    return cml_fail(err, CML_E_INPUT, "%s: this program was built without HDF5", path);
}

#endif
