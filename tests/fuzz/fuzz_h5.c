/* .h5 files: a whole result, changed by HDF5 as the input says, then read as a result. The input is a list
 * of changes: one byte each for what is done, to which object and how; so every
 * file is one that HDF5 itself has made, and what it holds is anything. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include <hdf5.h>
#include <hdf5_hl.h>
#include <math.h>

#include "result/h5.h"

enum { NR = 3, NZ = 2, NA = 2, NX = 3, NY = 2 };

/* ---- the whole result ---- */

static struct cml_axis axes[] = {
    {"r", "radius", "cm", NR, 0.05, 0.1, NULL},    {"z", "depth", "cm", NZ, 0.05, 0.1, NULL},
    {"alpha", "angle", "rad", NA, 0.4, 0.8, NULL}, {"layer", "layer", "1", 1, 1, 1, NULL},
    {"x", "x", "cm", NX, -0.1, 0.1, NULL},         {"y", "y", "cm", NY, -0.05, 0.1, NULL}};

static const struct {
    const char *name;
    int num_axes, axis[2];
} arrays[] = {
    {"Rsp", 0, {0}},    {"Rd", 0, {0}},       {"A", 0, {0}},           {"Tt", 0, {0}},
    {"Rsp_se", 0, {0}}, {"Rd_se", 0, {0}},    {"A_se", 0, {0}},        {"Tt_se", 0, {0}},
    {"A_l", 1, {3}},    {"A_z", 1, {1}},      {"Rd_r", 1, {0}},        {"Rd_r_se", 1, {0}},
    {"Rd_a", 1, {2}},   {"Tt_r", 1, {0}},     {"Tt_a", 1, {2}},        {"A_rz", 2, {0, 1}},
    {"lost", 0, {0}},   {"Rd_xy", 2, {5, 4}}, {"Rd_xy_se", 2, {5, 4}},
};
enum {
    ARRAYS = sizeof arrays / sizeof *arrays,
    AXES = sizeof axes / sizeof *axes,
    OBJECTS = ARRAYS + AXES + 3
};

static void ones(const void *context, size_t begin, size_t count, double *out)
{
    (void)context, (void)begin;
    for (size_t i = 0; i < count; i++) out[i] = 0.25;
}

static void write_base(const char *path, double seed)
{
    struct cml_field fields[ARRAYS] = {0};
    struct cml_error err = {CML_OK, ""};
    const struct cml_attribute attributes[] = {
        {"title", "s", 0},      {"sampling", "random", 0}, {"input", "s\n1\n1\n", 0}, {"beam", "b", 0},
        {"photons", NULL, 100}, {"seed", NULL, seed},      {"run", NULL, 1},          {"reentry", NULL, 1}};
    const struct cml_hdf5_call call = {"run", "s.mci"};
    for (int i = 0; i < ARRAYS; i++) {
        fields[i] = (struct cml_field){
            .long_name = "l", .units = "u", .num_axes = arrays[i].num_axes, .values = ones};
        strcpy(fields[i].name, arrays[i].name);
        fields[i].single = strncmp(arrays[i].name, "Rd_xy", 5) == 0;
        for (int k = 0; k < arrays[i].num_axes; k++) fields[i].axis[k] = &axes[arrays[i].axis[k]];
    }
    FUZZ_CHECK(cml_hdf5_write(path, attributes, sizeof attributes / sizeof *attributes, &call, fields, ARRAYS,
                              &err) == CML_OK);
}

/* ---- changes ---- */

struct input {
    const uint8_t *data;
    size_t size;
};

static unsigned next(struct input *in)
{
    if (in->size == 0) return 0;
    in->size--;
    return *in->data++;
}

/* Names of objects: those of a result, and some others. */
static const char *name_of(unsigned i)
{
    static const char *const others[] = {"other",
                                         "NNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNN",
                                         "NNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNNN"};
    i %= OBJECTS;
    return i < ARRAYS          ? arrays[i].name
           : i < ARRAYS + AXES ? axes[i - ARRAYS].name
                               : others[i - ARRAYS - AXES];
}

static hid_t type_of(unsigned i)
{
    const hid_t plain[] = {H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_IEEE_F64BE,  H5T_STD_I32LE,
                           H5T_STD_U64LE,  H5T_STD_I8LE,   H5T_STD_REF_OBJ, H5T_C_S1};
    const size_t lengths[] = {1, 2, 100, 5000, H5T_VARIABLE};
    i %= 16;
    if (i < 8) return H5Tcopy(plain[i]);
    if (i == 13) return H5Tvlen_create(H5T_IEEE_F64LE);
    if (i == 14) return H5Tarray_create2(H5T_IEEE_F64LE, 1, (hsize_t[]){300});
    if (i == 15) {
        const hid_t type = H5Tcreate(H5T_COMPOUND, 16);
        H5Tinsert(type, "dataset", 0, H5T_STD_REF_OBJ);
        H5Tinsert(type, "dimension", 8, H5T_NATIVE_INT);
        return type;
    }
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, lengths[i - 8]);
    return type;
}

/* Sizes of which only small ones are ever written. */
static hid_t space_of(struct input *in, int *axes_of, hsize_t n[8], bool grow)
{
    static const hsize_t sizes[] = {
        1, 2, 3, 5, 31, 700, 5000, 0, 1u << 16, 1ull << 31, (1ull << 32) + 1, 1ull << 51, (1ull << 61) + 1};
    hsize_t most[8];
    const unsigned shape = next(in);
    *axes_of = (int)(shape % 9);
    for (int i = 0; i < *axes_of && i < 8; i++) {
        n[i] = sizes[next(in) % (sizeof sizes / sizeof *sizes)];
        most[i] = grow ? H5S_UNLIMITED : n[i];
    }
    if (*axes_of == 8) {
        *axes_of = 0;
        return H5Screate(H5S_NULL);
    }
    return *axes_of ? H5Screate_simple(*axes_of, n, most) : H5Screate(H5S_SCALAR);
}

/* Values of any kind: what is read must fit, whatever it is. 0: too many. */
static size_t fill(hid_t type, hid_t space, struct input *in, void *room, size_t room_size)
{
    const hssize_t count = H5Sget_simple_extent_npoints(space);
    const size_t size = H5Tget_size(type);
    static const double numbers[] = {0.5, 0, -1, 1, 1e300, INFINITY, NAN, 3};
    hsize_t n[H5S_MAX_RANK];
    const int count_axes = H5Sget_simple_extent_dims(space, n, NULL);
    for (int i = 0; i < count_axes; i++)
        if (n[i] > room_size) return 0; /* the product of sizes may have wrapped */
    if (count <= 0 || size == 0 || (size_t)count > room_size / size) return 0;
    const double number = numbers[next(in) % 8];
    const float single = (float)number;
    const bool pointers = H5Tis_variable_str(type) > 0 || H5Tget_class(type) == H5T_VLEN;
    for (size_t i = 0; i < (size_t)count * size / 8 * 8; i += 8) memcpy((char *)room + i, &number, 8);
    if (size == 4)
        for (size_t i = 0; i < (size_t)count * 4; i += 4) memcpy((char *)room + i, &single, 4);
    if (H5Tget_class(type) == H5T_STRING) memset(room, 'a', (size_t)count * size);
    for (size_t i = 0; pointers && i < (size_t)count; i++) {
        static char text[] = "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa";
        if (H5Tget_class(type) == H5T_VLEN)
            ((hvl_t *)room)[i] = (hvl_t){5, text};
        else
            ((char **)room)[i] = text;
    }
    return (size_t)count;
}

static _Alignas(16) char room[1 << 13];

static void put_attribute(hid_t file, struct input *in)
{
    static const char *const names[] = {
        "title",      "sampling", "input",          "beam",          "photons",
        "seed",       "run",      "reentry",        "other",         "settings",
        "boundaries", "scene",    "units",          "long_name",     "ancillary_variables",
        "CLASS",      "NAME",     "REFERENCE_LIST", "DIMENSION_LIST"};
    hsize_t n[8];
    int count;
    const unsigned of = next(in);
    const char *name = names[next(in) % (sizeof names / sizeof *names)];
    const hid_t object = of < 128 ? H5Oopen(file, "/", H5P_DEFAULT) : H5Oopen(file, name_of(of), H5P_DEFAULT);
    const hid_t type = type_of(next(in)), space = space_of(in, &count, n, false);
    if (H5Aexists(object, name) > 0) H5Adelete(object, name);
    if (H5Sget_simple_extent_npoints(space) <= 5000) {
        const hid_t attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
        if (attribute >= 0 && fill(type, space, in, room, sizeof room)) H5Awrite(attribute, type, room);
        H5Aclose(attribute);
    }
    H5Sclose(space);
    H5Tclose(type);
    H5Oclose(object);
}

static hid_t properties_of(struct input *in, int count, const hsize_t *n)
{
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    const unsigned how = next(in), filters = next(in);
    hsize_t chunk[8];
    for (int i = 0; i < count; i++)
        chunk[i] = n[i] < 64 && n[i] > 0 ? n[i] : i + 1 == count && n[i] > 0 ? 64 : 1;
    if (how % 4 > 0 && count > 0) H5Pset_chunk(properties, count, chunk);
    if (how & 16) H5Pset_external(properties, "/dev/null", 0, 1 << 20);
    if (how & 32) H5Pset_fill_value(properties, H5T_NATIVE_INT, &(int){7});
    if (filters & 1) H5Pset_shuffle(properties);
    if (filters & 2) H5Pset_deflate(properties, 1);
    if (filters & 4) H5Pset_fletcher32(properties);
    if (filters & 8) H5Pset_deflate(properties, 1);
    if (filters & 16) H5Pset_filter(properties, 32000, H5Z_FLAG_OPTIONAL, 0, NULL);
    return properties;
}

static void put_dataset(hid_t file, struct input *in)
{
    hsize_t n[8] = {0};
    int count;
    const char *name = name_of(next(in));
    const unsigned kind = next(in);
    const hid_t type = type_of(kind), space = space_of(in, &count, n, kind & 128),
                properties = properties_of(in, count, n);
    H5Ldelete(file, name, H5P_DEFAULT);
    const hid_t dataset = H5Dcreate2(file, name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    if (dataset >= 0 && fill(type, space, in, room, sizeof room) && (kind & 64) == 0)
        H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, room);
    if (dataset >= 0 && next(in) & 1) H5DSset_scale(dataset, name);
    H5Dclose(dataset);
    H5Pclose(properties);
    H5Sclose(space);
    H5Tclose(type);
}

static void put_link(hid_t file, struct input *in)
{
    const char *name = name_of(next(in)), *other = name_of(next(in));
    const unsigned kind = next(in) % 5;
    H5Ldelete(file, name, H5P_DEFAULT);
    if (kind == 1) H5Lcreate_soft(other, file, name, H5P_DEFAULT, H5P_DEFAULT);
    if (kind == 2) H5Lcreate_external("/dev/zero", other, file, name, H5P_DEFAULT, H5P_DEFAULT);
    if (kind == 3) H5Lcreate_hard(file, other, file, name, H5P_DEFAULT, H5P_DEFAULT);
    if (kind == 4) H5Gclose(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
}

/* What stands in a chunk: bytes of the input, as if filters had left them. */
static void put_chunk(hid_t file, struct input *in)
{
    const hsize_t start[8] = {0};
    const hid_t dataset = H5Dopen2(file, name_of(next(in)), H5P_DEFAULT);
    const unsigned mask = next(in) & 3, size = next(in);
    for (unsigned i = 0; i < size; i++) room[i] = (char)next(in);
    if (dataset >= 0 && H5Dget_storage_size(dataset) > 0) /* without, H5Dwrite_chunk crashes */
        H5Dwrite_chunk(dataset, H5P_DEFAULT, mask, start, size, room);
    if (dataset >= 0) H5Dclose(dataset);
}

static void put_value(hid_t file, struct input *in)
{
    const hid_t dataset = H5Dopen2(file, name_of(next(in)), H5P_DEFAULT);
    const hid_t space = dataset >= 0 ? H5Dget_space(dataset) : -1;
    if (dataset < 0) return;
    if (fill(H5T_NATIVE_DOUBLE, space, in, room, sizeof room))
        H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, room);
    H5Sclose(space);
    H5Dclose(dataset);
}

/* A chunk of any bytes comes last: HDF5 itself would write beyond it. */
static void change(hid_t file, struct input *in)
{
    void (*const changes[])(hid_t, struct input *) = {put_attribute, put_dataset, put_link, put_value,
                                                      put_chunk};
    unsigned what = 0;
    for (int i = 0; i < 6 && in->size > 0 && what != 4; i++) {
        what = next(in) % 5;
        changes[what](file, in);
    }
}

/* ---- reading ---- */

static const char *path_of(const char *what)
{
    static char path[300];
    snprintf(path, sizeof path, "%s.%s.h5", fuzz_output(), what);
    return path;
}

static void read_result(const char *path)
{
    struct cml_outcome found;
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_h5_read(path, &found, &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return;
    }
    FUZZ_CHECK(found.photons >= 1 && isfinite(found.value[CML_QUANTITY_Rd][0]) &&
               isfinite(found.value[CML_QUANTITY_Tt_a][NA - 1]));
    cml_outcome_clear(&found);
}

/* What is left open in it would stay for the next input. */
static void close_file(hid_t file)
{
    FUZZ_CHECK(H5Fget_obj_count(file, H5F_OBJ_ALL) == 1);
    H5Fclose(file);
}

/* A file that is open already costs little to open again, as HDF5 keeps what it has read. The
 * base stays open for ever, the changed file for its readers; now and then they read what was closed. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char *base, path[300];
    static size_t base_size;
    static int changed = -1;
    struct cml_error err = {CML_OK, ""};
    struct input in = {data, size};
    if (!base) {
        H5set_free_list_limits(-1, -1, 4 << 20, 256 << 10, 16 << 20,
                               1 << 20); /* regular ones have few sizes */
        write_base(path_of("base"), 2);
        FUZZ_CHECK(cml_text_read_file(path_of("base"), SIZE_MAX, &base, &base_size, &err) == CML_OK);
        FUZZ_CHECK(H5Fopen(path_of("base"), H5F_ACC_RDONLY, H5P_DEFAULT) >= 0);
        strcpy(path, path_of("changed"));
        changed = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
        FUZZ_CHECK(changed >= 0);
    }
    FUZZ_CHECK(ftruncate(changed, 0) == 0 && pwrite(changed, base, base_size, 0) == (ssize_t)base_size);
    const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    FUZZ_CHECK(file >= 0);
    change(file, &in);
    H5Fflush(file, H5F_SCOPE_GLOBAL);
    const bool closed = size % 16 == 0;
    if (closed) close_file(file);
    read_result(path);
    if (!closed) close_file(file);
    return 0;
}
