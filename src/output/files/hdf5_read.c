/* SPDX-License-Identifier: MIT */
#include "output/files/hdf5_read.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#ifdef CML_HDF5
#include <fcntl.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

/* Deflate makes no more than 1032 bytes of one (Deutsch, RFC 1951: 258 bytes of two bits). */
enum { MOST_INFLATED = 1032 };

struct cml_hdf5_chunks {
    bool shuffled, deflated;
    size_t n[CML_FIELD_AXES], size; /* values along each axis, and of a chunk */
    hsize_t start[CML_FIELD_AXES];  /* of the chunk that is held */
    unsigned char *bytes;           /* of that chunk, inflated; NULL: none is held */
};

static size_t bytes_of_value(const struct cml_hdf5_dataset *dataset)
{
    return dataset->single ? 4 : 8;
}

static cml_status refuse(const struct cml_hdf5 *file, const char *name, const char *is, const char *expected,
                         struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "%.400s: %.80s %s (expected %s)", file->path, name, is, expected);
}

/* ---- the file ---- */

/* H5Fopen without a lock: results are read-only here, and some file systems know no locks (NFS). HDF5 before
 * 1.10.7 and 1.12.0 lock always. Returns a negative number on failure. */
static hid_t open_unlocked(const char *path)
{
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
#if H5_VERSION_GE(1, 12, 1) || (H5_VERSION_GE(1, 10, 7) && !H5_VERSION_GE(1, 12, 0))
    (void)H5Pset_file_locking(access, false, true);
#endif
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, access);
    H5Pclose(access);
    return file;
}

/* The library prints nothing and loads no filters from other places; what failed, our line says. O_NONBLOCK:
 * a FIFO would be waited for. */
cml_status cml_hdf5_open(const char *path, struct cml_hdf5 *file, struct cml_error *err)
{
    struct stat status;
    (void)H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    (void)H5PLset_loading_state(0);
    *file = (struct cml_hdf5){.path = path, .descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (file->descriptor < 0)
        return cml_fail(err, CML_E_INPUT, "%s: cannot be read: %s (expected an .h5 file)", path,
                        strerror(errno));
    const bool regular = fstat(file->descriptor, &status) == 0 && S_ISREG(status.st_mode);
    file->id = regular ? open_unlocked(path) : -1;
    file->bytes = regular ? (size_t)status.st_size : 0;
    if (file->id >= 0) return CML_OK;
    (void)close(file->descriptor);
    if (!regular) return cml_fail(err, CML_E_INPUT, "%s: is no regular file (expected an .h5 file)", path);
    return cml_fail(err, CML_E_INPUT, "%s: cannot be read as an HDF5 file (expected the .h5 file of a run)",
                    path);
}

void cml_hdf5_close(struct cml_hdf5 *file)
{
    if (file->id > 0) {
        H5Fclose(file->id);
        (void)close(file->descriptor);
    }
    *file = (struct cml_hdf5){0};
}

size_t cml_hdf5_most_numbers(const struct cml_hdf5 *file)
{
    return file->bytes / 4 * MOST_INFLATED;
}

/* ---- what a data set is ---- */

static cml_status check_type(struct cml_hdf5_dataset *dataset, struct cml_error *err)
{
    const hid_t type = H5Dget_type(dataset->id);
    dataset->single = H5Tequal(type, H5T_IEEE_F32LE) > 0;
    const bool good = dataset->single || H5Tequal(type, H5T_IEEE_F64LE) > 0;
    H5Tclose(type);
    if (good) return CML_OK;
    return refuse(dataset->file, dataset->name, "is of another type", "floating-point numbers", err);
}

/* The product of the sizes stays far below what a size_t holds. */
static cml_status check_shape(struct cml_hdf5_dataset *dataset, struct cml_error *err)
{
    hsize_t n[H5S_MAX_RANK], most[H5S_MAX_RANK];
    const size_t bytes = bytes_of_value(dataset);
    const hid_t space = H5Dget_space(dataset->id);
    const bool simple = H5Sis_simple(space) > 0 && H5Sget_simple_extent_type(space) != H5S_NULL;
    const int axes = simple ? H5Sget_simple_extent_dims(space, n, most) : -1;
    H5Sclose(space);
    if (axes < 0 || axes > CML_FIELD_AXES)
        return refuse(dataset->file, dataset->name, "has another number of axes", "0 to 6 of them", err);
    dataset->num_axes = axes;
    dataset->size = 1;
    for (int i = 0; i < axes; i++) {
        dataset->n[i] = (size_t)n[i];
        if (n[i] != most[i] || n[i] == 0)
            return refuse(dataset->file, dataset->name, "has an axis that is empty or can grow",
                          "axes of one size", err);
        if (n[i] > (hsize_t)dataset->file->bytes * MOST_INFLATED / bytes / dataset->size)
            return refuse(dataset->file, dataset->name, "has more numbers than its file can hold",
                          "those of a run", err);
        dataset->size *= (size_t)n[i];
    }
    return CML_OK;
}

/* At most one shuffle over the bytes of a value, then at most one deflate. */
static bool read_filters(struct cml_hdf5_dataset *dataset, hid_t properties)
{
    struct cml_hdf5_chunks *chunks = dataset->chunks;
    const int count = H5Pget_nfilters(properties);
    for (int i = 0; i < count; i++) {
        unsigned flags = 0, parameter = 0;
        size_t parameters = 1;
        const H5Z_filter_t filter =
            H5Pget_filter2(properties, (unsigned)i, &flags, &parameters, &parameter, 0, NULL, NULL);
        if (filter == H5Z_FILTER_SHUFFLE && i == 0 && parameter == bytes_of_value(dataset))
            chunks->shuffled = true;
        else if (filter == H5Z_FILTER_DEFLATE && i == count - 1)
            chunks->deflated = true;
        else
            return false;
    }
    return count >= 0 && count <= 1 + (int)chunks->shuffled;
}

static bool read_chunk_sizes(struct cml_hdf5_dataset *dataset, hid_t properties)
{
    struct cml_hdf5_chunks *chunks = dataset->chunks;
    hsize_t n[CML_FIELD_AXES];
    if (H5Pget_chunk(properties, CML_FIELD_AXES, n) != dataset->num_axes) return false;
    chunks->size = 1;
    for (int i = 0; i < dataset->num_axes; i++) {
        if (n[i] < 1 || n[i] > dataset->n[i]) return false;
        chunks->n[i] = (size_t)n[i];
        chunks->size *= chunks->n[i];
    }
    return true;
}

/* Arrays are chunked, or lie in one piece, as a single number does, and are there: no fill value stands for
 * them. */
static cml_status check_layout(struct cml_hdf5_dataset *dataset, hid_t properties, struct cml_error *err)
{
    const H5D_layout_t layout = H5Pget_layout(properties);
    if (layout == H5D_VIRTUAL || H5Pget_external_count(properties) != 0)
        return refuse(dataset->file, dataset->name, "has its values in other files", "values of its own",
                      err);
    CML_TRY(check_shape(dataset, err));
    const bool one_piece = layout == H5D_CONTIGUOUS;
    if (!one_piece && (layout != H5D_CHUNKED || dataset->num_axes == 0))
        return refuse(dataset->file, dataset->name, "is stored in another way", "chunks, or one piece", err);
    const hsize_t stored = H5Dget_storage_size(dataset->id), most = stored * (one_piece ? 1 : MOST_INFLATED);
    if (stored > dataset->file->bytes || most < dataset->size * bytes_of_value(dataset))
        return refuse(dataset->file, dataset->name, "has values that are not there", "all of them", err);
    if (one_piece) return CML_OK;
    dataset->chunks = calloc(1, sizeof *dataset->chunks);
    if (!dataset->chunks) return cml_fail_memory(err, sizeof *dataset->chunks, dataset->name);
    if (!read_filters(dataset, properties))
        return refuse(dataset->file, dataset->name, "is packed by other filters", "shuffle and deflate", err);
    if (read_chunk_sizes(dataset, properties)) return CML_OK;
    return refuse(dataset->file, dataset->name, "has chunks beyond its axes", "chunks within them", err);
}

/* The type comes first: of others not even the fill value is looked at. */
static cml_status check_dataset(struct cml_hdf5_dataset *dataset, struct cml_error *err)
{
    CML_TRY(check_type(dataset, err));
    const hid_t properties = H5Dget_create_plist(dataset->id);
    const cml_status status = check_layout(dataset, properties, err);
    H5Pclose(properties);
    return status;
}

/* ---- finding data sets ---- */

/* Only hard links, which lead to an object of the same file. An object that is no data set stays closed. */
static cml_status open_object(const struct cml_hdf5 *file, const char *name, hid_t *object,
                              struct cml_error *err)
{
    H5L_info_t link;
    *object = -1;
    if (strchr(name, '/') || H5Lget_info(file->id, name, &link, H5P_DEFAULT) < 0) return CML_OK;
    if (link.type != H5L_TYPE_HARD)
        return refuse(file, name, "is a link to another place", "a data set of this file", err);
    *object = H5Oopen(file->id, name, H5P_DEFAULT);
    if (*object < 0) return refuse(file, name, "cannot be read", "a data set", err);
    if (H5Iget_type(*object) == H5I_DATASET) return CML_OK;
    H5Oclose(*object);
    *object = -1;
    return CML_OK;
}

cml_status cml_hdf5_dataset_open(const struct cml_hdf5 *file, const char *name,
                                 struct cml_hdf5_dataset *dataset, struct cml_error *err)
{
    hid_t object;
    *dataset = (struct cml_hdf5_dataset){.file = file};
    if (strlen(name) >= sizeof dataset->name)
        return refuse(file, name, "is a name of 64 characters or more", "a shorter one", err);
    CML_TRY(open_object(file, name, &object, err));
    if (object < 0) return CML_OK;
    dataset->id = object;
    strcpy(dataset->name, name);
    const cml_status status = check_dataset(dataset, err);
    if (status != CML_OK) cml_hdf5_dataset_close(dataset);
    return status;
}

void cml_hdf5_dataset_close(struct cml_hdf5_dataset *dataset)
{
    if (dataset->chunks) free(dataset->chunks->bytes);
    free(dataset->chunks);
    if (dataset->id > 0) H5Oclose(dataset->id);
    *dataset = (struct cml_hdf5_dataset){0};
}

/* ---- values ---- */

/* The number in bytes `stride` apart, lowest first. */
static double decode(const unsigned char *bytes, size_t stride, bool is_single)
{
    uint64_t bits = 0;
    for (size_t b = 0; b < (is_single ? 4 : 8); b++) bits |= (uint64_t)bytes[b * stride] << 8 * b;
    const uint32_t half = (uint32_t)bits;
    double number;
    float single;
    memcpy(&number, &bits, sizeof number);
    memcpy(&single, &half, sizeof single);
    return is_single ? (double)single : number;
}

/* Number i of the chunk that is held; shuffled, all first bytes come first. */
static double value_of(const struct cml_hdf5_dataset *dataset, size_t i)
{
    const struct cml_hdf5_chunks *chunks = dataset->chunks;
    return chunks->shuffled ? decode(chunks->bytes + i, chunks->size, dataset->single)
                            : decode(chunks->bytes + i * bytes_of_value(dataset), 1, dataset->single);
}

static bool read_bytes(const struct cml_hdf5 *file, haddr_t at, unsigned char *bytes, size_t size)
{
    return at < file->bytes && size <= file->bytes - at &&
           pread(file->descriptor, bytes, size, (off_t)at) == (ssize_t)size;
}

/* Reads values that lie in one piece. */
static cml_status read_piece(const struct cml_hdf5_dataset *dataset, size_t begin, size_t count, double *out,
                             struct cml_error *err)
{
    enum { ROOM = 512 };
    unsigned char bytes[8 * ROOM];
    const size_t each = bytes_of_value(dataset);
    const haddr_t at = H5Dget_offset(dataset->id);
    for (size_t done = 0; done < count;) {
        const size_t left = count - done, values = left < ROOM ? left : ROOM;
        if (at >= dataset->file->bytes ||
            !read_bytes(dataset->file, at + (begin + done) * each, bytes, values * each))
            return refuse(dataset->file, dataset->name, "cannot be read", "a number", err);
        for (size_t i = 0; i < values; i++) out[done + i] = decode(bytes + i * each, 1, dataset->single);
        done += values;
    }
    return CML_OK;
}

/* Stored bytes as the filters left them; false when they are not what they make. */
static bool inflate_chunk(const struct cml_hdf5_dataset *dataset, haddr_t at, unsigned char *stored,
                          size_t stored_size, unsigned char *bytes)
{
    const size_t size = dataset->chunks->size * bytes_of_value(dataset);
    uLongf inflated = (uLongf)size;
    if (!read_bytes(dataset->file, at, stored, stored_size)) return false;
    if (dataset->chunks->deflated)
        return uncompress(bytes, &inflated, stored, (uLong)stored_size) == Z_OK && inflated == size;
    if (stored_size == size) memcpy(bytes, stored, size);
    return stored_size == size;
}

/* Reads the chunk of a data set that begins at `start`, and holds it. */
static cml_status hold_chunk(const struct cml_hdf5_dataset *dataset, const hsize_t *start,
                             struct cml_error *err)
{
    struct cml_hdf5_chunks *chunks = dataset->chunks;
    const size_t size = chunks->size * bytes_of_value(dataset), axes = (size_t)dataset->num_axes;
    hsize_t stored_size = 0;
    unsigned left_out = 0;
    haddr_t at = HADDR_UNDEF;
    if (chunks->bytes && memcmp(start, chunks->start, axes * sizeof *start) == 0) return CML_OK;
    free(chunks->bytes);
    chunks->bytes = NULL;
    if (H5Dget_chunk_info_by_coord(dataset->id, start, &left_out, &at, &stored_size) < 0 ||
        stored_size == 0 || stored_size > dataset->file->bytes)
        return refuse(dataset->file, dataset->name, "has a chunk that is not there", "all of them", err);
    unsigned char *stored = malloc((size_t)stored_size), *bytes = malloc(size);
    cml_status status =
        stored && bytes ? CML_OK : cml_fail_memory(err, (double)stored_size + (double)size, dataset->name);
    if (status == CML_OK &&
        (left_out != 0 || !inflate_chunk(dataset, at, stored, (size_t)stored_size, bytes)))
        status =
            refuse(dataset->file, dataset->name, "cannot be read", "chunks of the size that it names", err);
    free(stored);
    if (status != CML_OK) {
        free(bytes);
        return status;
    }
    chunks->bytes = bytes;
    memcpy(chunks->start, start, axes * sizeof *start);
    return CML_OK;
}

/* The chunk with value number `at`, and which of its values that is. Returns how many more of the array
 * follow it there, itself among them: to the end of the row or of the chunk. */
static size_t find_in_chunk(const struct cml_hdf5_dataset *dataset, size_t at, hsize_t *start, size_t *inside)
{
    const struct cml_hdf5_chunks *chunks = dataset->chunks;
    size_t stride = 1, left = 0;
    *inside = 0;
    for (int i = dataset->num_axes - 1; i >= 0; i--) {
        const size_t place = at % dataset->n[i], in = place % chunks->n[i];
        const size_t rest = dataset->n[i] - place, rest_of_chunk = chunks->n[i] - in;
        at /= dataset->n[i];
        start[i] = place - in;
        *inside += in * stride;
        stride *= chunks->n[i];
        if (i == dataset->num_axes - 1) left = rest < rest_of_chunk ? rest : rest_of_chunk;
    }
    return left;
}

cml_status cml_hdf5_values(const struct cml_hdf5_dataset *dataset, size_t begin, size_t count, double *out,
                           struct cml_error *err)
{
    hsize_t start[CML_FIELD_AXES] = {0};
    if (begin > dataset->size || count > dataset->size - begin)
        return refuse(dataset->file, dataset->name, "has fewer numbers", "more of them", err);
    if (!dataset->chunks) return read_piece(dataset, begin, count, out, err);
    for (size_t done = 0; done < count;) {
        size_t inside;
        const size_t left = find_in_chunk(dataset, begin + done, start, &inside), more = count - done;
        const size_t values = left < more ? left : more;
        CML_TRY(hold_chunk(dataset, start, err));
        for (size_t i = 0; i < values; i++) out[done + i] = value_of(dataset, inside + i);
        done += values;
    }
    return CML_OK;
}

/* ---- attributes ---- */

/* Opens an attribute of a data set, or of the root; -1: there is none. */
static hid_t open_attribute(const struct cml_hdf5 *file, const struct cml_hdf5_dataset *dataset,
                            const char *name)
{
    const hid_t object = dataset ? dataset->id : file->id;
    return H5Aexists(object, name) > 0 ? H5Aopen(object, name, H5P_DEFAULT) : -1;
}

/* How many elements; -1: not along `axes` axes. */
static hssize_t elements_of(hid_t attribute, int axes)
{
    const hid_t space = H5Aget_space(attribute);
    const bool good = H5Sget_simple_extent_type(space) == (axes ? H5S_SIMPLE : H5S_SCALAR) &&
                      H5Sget_simple_extent_ndims(space) == axes;
    const hssize_t count = good ? H5Sget_simple_extent_npoints(space) : -1;
    H5Sclose(space);
    return count;
}

cml_status cml_hdf5_number(const struct cml_hdf5 *file, const char *name, double *number,
                           struct cml_error *err)
{
    const hid_t attribute = open_attribute(file, NULL, name);
    if (attribute < 0) return CML_OK;
    const hid_t type = H5Aget_type(attribute);
    const bool good = elements_of(attribute, 0) == 1 && H5Tequal(type, H5T_IEEE_F64LE) > 0 &&
                      H5Aread(attribute, H5T_NATIVE_DOUBLE, number) >= 0;
    H5Tclose(type);
    H5Aclose(attribute);
    return good ? CML_OK : refuse(file, name, "is of another type or shape", "one number of 64 bits", err);
}

/* Into length + 1 bytes, which end with a zero. */
static bool read_text(hid_t attribute, hid_t type, size_t length, char *text)
{
    const hid_t wanted = H5Tcopy(H5T_C_S1);
    const bool good = H5Tset_size(wanted, length + 1) >= 0 && H5Tset_cset(wanted, H5Tget_cset(type)) >= 0 &&
                      H5Aread(attribute, wanted, text) >= 0;
    H5Tclose(wanted);
    text[length] = '\0';
    return good;
}

cml_status cml_hdf5_text(const struct cml_hdf5 *file, const struct cml_hdf5_dataset *dataset,
                         const char *name, char **text, struct cml_error *err)
{
    const hid_t attribute = open_attribute(file, dataset, name);
    const hid_t type = attribute < 0 ? -1 : H5Aget_type(attribute);
    const bool fixed = attribute >= 0 && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 &&
                       elements_of(attribute, 0) == 1 && H5Tget_size(type) <= file->bytes;
    const size_t length = fixed ? H5Tget_size(type) : 0;
    cml_status status = CML_OK;
    *text = calloc(length + 1, 1);
    if (!*text)
        status = cml_fail_memory(err, (double)length, name);
    else if (attribute >= 0 && !(fixed && read_text(attribute, type, length, *text)))
        status = refuse(file, name, "is of another type or shape", "one text of fixed length", err);
    if (attribute >= 0) H5Tclose(type), H5Aclose(attribute);
    if (status == CML_OK) return CML_OK;
    free(*text);
    *text = NULL;
    return status;
}

#else

cml_status cml_hdf5_open(const char *path, struct cml_hdf5 *file, struct cml_error *err)
{
    *file = (struct cml_hdf5){0};
    return cml_fail(err, CML_E_INPUT, "%s: this program was built without HDF5", path);
}

void cml_hdf5_close(struct cml_hdf5 *file)
{
    *file = (struct cml_hdf5){0};
}

cml_status cml_hdf5_number(const struct cml_hdf5 *file, const char *name, double *number,
                           struct cml_error *err)
{
    (void)name, (void)number;
    return cml_hdf5_open(file->path, &(struct cml_hdf5){0}, err);
}

#endif
