/* SPDX-License-Identifier: MIT */
#include "output/files/hdf5_file.h"

#include "base/atomic_file.h"

#include <stdlib.h>
#include <string.h>

#ifdef CML_HDF5
#include <hdf5.h>
#include <hdf5_hl.h>
#include <pthread.h>

#define CHUNK ((size_t)1 << 17)  /* values that are in memory as doubles at a time */
#define GROWTH ((size_t)1 << 20) /* bytes by which the file in memory grows */
/* Name of the file for HDF5, which is made in memory. HDF5 first tries to open a file of this name, so it is
 * one that cannot exist. */
#define NOWHERE "/dev/null/none"

/* State of writing one file. HDF5 makes the file in memory, and this program writes it to the disk: HDF5
 * itself would keep what the disk refuses, report it at some later call, and write wrong bytes then. In
 * memory only memory can run out. Calls of the library return a negative number when they fail. The first
 * failure is remembered; later calls fail because its handles are invalid, or do nothing. The code therefore
 * runs straight on, and tests for a failure once, at the end. */
struct writer {
    hid_t file;
    bool failed;
    double *buffer;       /* [CHUNK] values of the current chunk */
    float *narrow;        /* [CHUNK] the values in single precision */
    unsigned char *image; /* bytes of the file, which stay when the library closes it */
    size_t size, room;    /* bytes of the file, and bytes allocated */
    size_t refused;       /* bytes that could not be allocated; 0: none */
};

/* Remembers that a call of the library has failed. */
static void check(struct writer *w, int64_t returned)
{
    if (returned < 0) w->failed = true;
}

/* Returns a handle, and remembers if making it has failed. */
static hid_t made(struct writer *w, hid_t handle)
{
    check(w, handle);
    return handle;
}

/* Writes a text as an attribute of the file or of a data set. UTF-8, because names of files may have any
 * letters. */
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

/* Writes a number as an attribute. All numbers are doubles: their 2^53 is enough for seeds and photons, and
 * every reader has doubles. */
static void put_number(struct writer *w, hid_t object, const char *name, double number)
{
    const hid_t space = made(w, H5Screate(H5S_SCALAR));
    const hid_t attribute =
        made(w, H5Acreate2(object, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT));
    check(w, H5Awrite(attribute, H5T_NATIVE_DOUBLE, &number));
    check(w, H5Aclose(attribute));
    check(w, H5Sclose(space));
}

/* Chooses the size of chunks: the last axes as a whole, as many as fit, then a part of the next axis. A chunk
 * then holds successive values, and is computed, compressed and forgotten at once. */
static void choose_chunk(const struct cml_field *field, hsize_t *chunk)
{
    size_t room = CHUNK;
    for (int i = field->num_axes - 1; i >= 0; i--) {
        chunk[i] = field->axis[i]->n < room ? field->axis[i]->n : room;
        if (chunk[i] == 0) chunk[i] = 1; /* an empty array still needs a chunk of one */
        room = chunk[i] < field->axis[i]->n ? 1 : room / (size_t)chunk[i];
    }
}

/* Creates the data set of a field, without times, so that the same fields give the same bytes. Data are
 * shuffled (all first bytes, all second bytes, ...) before compression, which then finds the digits that
 * neighbours share. A single number stands in the data set's header, which has a checksum. */
static hid_t create_dataset(struct writer *w, const struct cml_field *field, const hsize_t *chunk)
{
    hsize_t size[CML_FIELD_AXES];
    for (int i = 0; i < field->num_axes; i++) size[i] = field->axis[i]->n;
    const hid_t space =
        made(w, field->num_axes ? H5Screate_simple(field->num_axes, size, NULL) : H5Screate(H5S_SCALAR));
    const hid_t properties = made(w, H5Pcreate(H5P_DATASET_CREATE));
    check(w, H5Pset_obj_track_times(properties, false));
    /* every value is written */
    if (field->plain) check(w, H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER));
    if (field->num_axes == 0) check(w, H5Pset_layout(properties, H5D_COMPACT));
    /* an empty array has no chunks */
    if (cml_field_size(field) > 0 && field->num_axes > 0 && !field->plain) {
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

/* Returns `count` values in the field's precision. Rounding to floats here is faster than in the library. */
static const void *get_values(struct writer *w, const struct cml_field *field, size_t begin, size_t count)
{
    field->values(field->context, begin, count, w->buffer);
    if (field->broken && *field->broken) w->failed = true;
    if (!field->single) return w->buffer;
    for (size_t i = 0; i < count; i++) w->narrow[i] = (float)w->buffer[i];
    return w->narrow;
}

/* Returns the type of the field's values in memory. */
static hid_t type_here(const struct cml_field *field)
{
    return field->single ? H5T_NATIVE_FLOAT : H5T_NATIVE_DOUBLE;
}

/* Writes one chunk, cut off at the end of the array. Returns how many values it has. */
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

/* Writes an array chunk by chunk. Each chunk is computed when it is written, so a volume of 1e9 voxels is
 * never in memory as doubles. Stops after the first failure. */
static void write_values(struct writer *w, hid_t dataset, const struct cml_field *field, const hsize_t *chunk)
{
    hsize_t start[CML_FIELD_AXES] = {0};
    for (size_t begin = 0; !w->failed && begin < cml_field_size(field);) {
        begin += write_chunk(w, dataset, field, start, chunk, begin);
        int axis = field->num_axes - 1;
        for (; axis >= 0; axis--) { /* steps to the next chunk like an odometer */
            start[axis] += chunk[axis];
            if (start[axis] < field->axis[axis]->n) break;
            start[axis] = 0;
        }
    }
}

/* Computes the middles of bins from their numbers rather than by adding steps, so that rounding errors do not
 * add up. */
static void axis_values(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_axis *axis = context;
    for (size_t i = begin; i < begin + count; i++)
        *out++ = axis->values ? axis->values[i] : axis->first + (double)i * axis->step;
}

/* Writes long name, units and errors under the names of the CF conventions, which xarray uses for display and
 * plots. */
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

/* Returns the open data set even after a failure, because the caller closes it. */
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

/* Opens the dimension scale of an axis; creates it if no field before had this axis. */
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

/* True if a field is its own axis. */
static bool is_axis(const struct cml_field *field)
{
    return field->num_axes == 1 && strcmp(field->name, field->axis[0]->name) == 0;
}

/* Writes a field and attaches its axes as dimension scales, which xarray and MATLAB use as coordinates. */
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

/* Writes a text about the call, as data of fixed length in one piece: files of two calls then differ in these
 * bytes only. An attribute would have a checksum, which differs as well. */
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

/* Writes the group `call`: the command line and the name of the input file. Only this group differs between
 * equal runs. */
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

/* Writes attributes (texts or numbers), the group `call` and all fields to an open file, until one fails.
 * w->failed remembers the first failure. */
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

/* Replaces realloc in HDF5's driver for files in memory: the functions below keep the memory of the file, and
 * count its size. */
static void *grow_image(void *old, size_t size, H5FD_file_image_op_t why, void *writer)
{
    struct writer *w = writer;
    (void)why;
    unsigned char *larger = realloc(old, size);
    if (!larger) {
        w->refused = size;
        return NULL;
    }
    /* HDF5 does not write every byte: without zeros, equal runs would have different files */
    if (size > w->room) memset(larger + w->room, 0, size - w->room);
    w->image = larger;
    w->room = size;
    return larger;
}

/* Replaces free in HDF5's driver: the memory of the file stays. */
static herr_t keep_image(void *image, H5FD_file_image_op_t why, void *writer)
{
    (void)image, (void)why, (void)writer;
    return 0;
}

/* Gives HDF5 our own writer where it would make a copy. */
static void *same_writer(void *writer)
{
    return writer;
}

/* Keeps the writer when HDF5 would free its copy: HDF5 gets this program's own writer (same_writer). */
static herr_t keep_writer(void *writer)
{
    (void)writer;
    return 0;
}

/* Creates the file in the format of HDF5 1.8, in which an attribute (the input text) may be longer than 64
 * KiB. */
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

/* Returns the end of the file from its superblock, version 2 in all files of HDF5 1.8 (HDF5 File Format
 * Specification, II.A). 0: the file was not closed properly. */
static size_t end_of_file(const struct writer *w)
{
    enum { VERSION = 8, OFFSETS = 9, WRITERS = 11, END = 28, SIZE = 48 };
    uint64_t end = 0;
    if (w->room < SIZE || w->image[VERSION] != 2 || w->image[OFFSETS] != sizeof end || w->image[WRITERS] != 0)
        return 0;
    for (size_t i = sizeof end; i > 0; i--) end = end << 8 | w->image[END + i - 1];
    return end <= w->room ? (size_t)end : 0;
}

/* Closes the file. Only afterwards does the superblock have the end of the file, and no mark of an open
 * writer. */
static void close_file(struct writer *w)
{
    check(w, H5Fclose(w->file));
    w->size = end_of_file(w);
    if (w->size == 0) w->failed = true;
}

/* Writes the file that HDF5 has built in memory to the disk, unless a step of building it failed. */
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

/* held by the one writer: HDF5 is not safe for several threads as Debian builds it */
static pthread_mutex_t one_writer = PTHREAD_MUTEX_INITIALIZER;

cml_status cml_hdf5_write(const char *path, const struct cml_attribute *attributes, int num_attributes,
                          const struct cml_hdf5_call *call, const struct cml_field *fields, int num_fields,
                          struct cml_error *err)
{
    const size_t size = CHUNK * (sizeof(double) + sizeof(float));
    struct writer w = {.buffer = malloc(size)};
    if (!w.buffer) return cml_fail_memory(err, (double)size, "an HDF5 file");
    w.narrow = (float *)(w.buffer + CHUNK);
    pthread_mutex_lock(&one_writer);
    create_file(&w);
    write_all(&w, attributes, num_attributes, call, fields, num_fields);
    close_file(&w);
    pthread_mutex_unlock(&one_writer);
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
