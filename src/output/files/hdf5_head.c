/* SPDX-License-Identifier: MIT */
#include "output/files/hdf5_head.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef CML_HDF5
#include <hdf5.h>
#include <zlib.h>

/* Opens a file for reading, without a lock, because some file systems have none (NFS). HDF5 before 1.10.7,
 * and 1.12.0, cannot leave the lock out. HDF5 prints no errors and loads no filters from other files. */
static hid_t open_unlocked(const char *path)
{
    (void)H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    (void)H5PLset_loading_state(0);
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
#if H5_VERSION_GE(1, 12, 1) || (H5_VERSION_GE(1, 10, 7) && !H5_VERSION_GE(1, 12, 0))
    (void)H5Pset_file_locking(access, false, true);
#endif
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, access);
    H5Pclose(access);
    return file;
}

/* Reads an attribute that is one number, or one text of fixed length, not longer than the type `wanted`. */
static bool read_attribute(hid_t file, const char *name, hid_t wanted, void *value)
{
    const hid_t attribute = H5Aopen(file, name, H5P_DEFAULT);
    if (attribute < 0) return false;
    const hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
    const bool good = H5Tget_class(type) == H5Tget_class(wanted) && H5Tis_variable_str(type) == 0 &&
                      H5Tget_size(type) <= H5Tget_size(wanted) &&
                      H5Sget_simple_extent_type(space) == H5S_SCALAR &&
                      H5Aread(attribute, wanted, value) >= 0;
    H5Sclose(space);
    H5Tclose(type);
    H5Aclose(attribute);
    return good;
}

/* Reads an attribute that is one text into value[size]. False if it is missing or too long. */
static bool read_text(hid_t file, const char *name, size_t size, char *value)
{
    const hid_t text = H5Tcopy(H5T_C_S1);
    const bool good = H5Tset_size(text, size) >= 0 && H5Tset_cset(text, H5T_CSET_UTF8) >= 0 &&
                      read_attribute(file, name, text, value);
    H5Tclose(text);
    value[size - 1] = '\0';
    return good;
}

/* Reads the identity, if the file has one. False: the attribute is damaged. */
static bool read_identity(hid_t file, struct cml_hdf5_head *head)
{
    return H5Aexists(file, "identity") <= 0 ||
           read_text(file, "identity", sizeof head->identity, head->identity);
}

/* ---- chunks ---- */

/* Bytes of a chunk of cml_hdf5_write, inflated and deflated, at most. */
enum { MOST_BYTES = 1 << 20, MOST_STORED = MOST_BYTES + (1 << 12) };

/* True if chunk i of a data set can be inflated. stored, bytes: room for the chunk. */
static bool is_chunk_sound(hid_t dataset, hid_t space, hsize_t i, unsigned char *stored, unsigned char *bytes)
{
    hsize_t start[H5S_MAX_RANK], size = 0;
    unsigned left_out = 0;
    haddr_t at;
    uLongf inflated = MOST_BYTES;
    return H5Dget_chunk_info(dataset, space, i, start, &left_out, &at, &size) >= 0 && size <= MOST_STORED &&
           H5Dread_chunk(dataset, H5P_DEFAULT, start, &left_out, stored) >= 0 && left_out == 0 &&
           uncompress(bytes, &inflated, stored, (uLong)size) == Z_OK;
}

/* Checks a compressed data set by unpacking every chunk: zlib then compares its checksum. */
static bool are_chunks_sound(hid_t dataset)
{
    unsigned char *stored = malloc(MOST_STORED + MOST_BYTES);
    const hid_t space = H5Dget_space(dataset);
    hsize_t count = 0;
    bool sound = stored && H5Dget_num_chunks(dataset, space, &count) >= 0;
    for (hsize_t i = 0; sound && i < count; i++)
        sound = is_chunk_sound(dataset, space, i, stored, stored + MOST_STORED);
    H5Sclose(space);
    free(stored);
    return sound;
}

/* True if the array NAME + ENDING is sound, or the file has no such array. Arrays are looked up by name,
 * because HDF5 1.10 frees memory that it does not own when it lists the links of a damaged file. */
static bool is_array_sound(hid_t file, const char *name, const char *ending)
{
    char path[64];
    snprintf(path, sizeof path, "%s%s", name, ending);
    const htri_t there = H5Lexists(file, path, H5P_DEFAULT);
    if (there <= 0) return there == 0;
    const hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
    if (dataset < 0) return false;
    const hid_t properties = H5Dget_create_plist(dataset);
    const bool sound = H5Pget_layout(properties) != H5D_CHUNKED || are_chunks_sound(dataset);
    H5Pclose(properties);
    H5Dclose(dataset);
    return sound;
}

bool cml_hdf5_read_head(const char *path, const char *const *arrays, int count, struct cml_hdf5_head *head)
{
    memset(head, 0, sizeof *head);
    const hid_t file = open_unlocked(path);
    if (file < 0) return false;
    bool good =
        read_attribute(file, "photons", H5T_NATIVE_DOUBLE, &head->photons) && read_identity(file, head);
    for (int i = 0; good && i < count; i++)
        good = is_array_sound(file, arrays[i], "") && is_array_sound(file, arrays[i], "_se");
    head->has_totals = H5Lexists(file, "Rd", H5P_DEFAULT) > 0;
    H5Fclose(file);
    return good;
}

bool cml_hdf5_is_foreign(const char *path)
{
    char source[128] = "";
    const hid_t file = open_unlocked(path);
    if (file < 0) return false;
    const htri_t there = H5Aexists(file, "source");
    if (there > 0) (void)read_text(file, "source", sizeof source, source);
    H5Fclose(file);
    return there >= 0 && strncmp(source, CML_HDF5_SOURCE, strlen(CML_HDF5_SOURCE)) != 0;
}

#else

bool cml_hdf5_read_head(const char *path, const char *const *arrays, int count, struct cml_hdf5_head *head)
{
    (void)path, (void)arrays, (void)count;
    memset(head, 0, sizeof *head);
    return false;
}

bool cml_hdf5_is_foreign(const char *path)
{
    (void)path;
    return false;
}

#endif
