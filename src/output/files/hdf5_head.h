/* What an .h5 file says of its run. SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* Begins the attribute `source` of every file that the program writes. */
#define CML_HDF5_SOURCE "clustermcml: "

struct cml_hdf5_head {
    double photons;
    char identity[17]; /* 16 digits; "": the file has none */
    bool has_totals;   /* the file of a run has, the file of saved packets has not */
};

/* Reads the attributes `photons` and `identity` of a file that cml_hdf5_write has written. false: the path
 * leads to no such file, or the file is damaged. The library compares the size of the file with the
 * superblock, so a cut file is refused, and the checksums of the superblock, of attributes and of the
 * headers of data sets. zlib compares those of the chunks of `arrays`, of which the file need not have any,
 * and of their errors. Not noticed are changes in other arrays, in numbers that are not deflated (saved
 * packets), in texts of the call and in bytes that nothing uses. A program without HDF5 refuses all. */
bool cml_hdf5_read_head(const char *path, const char *const *arrays, int count, struct cml_hdf5_head *head);

/* True if the path leads to a sound HDF5 file of another program: HDF5 opens the file, and no attribute
 * `source` at its root begins with CML_HDF5_SOURCE. A program without HDF5 knows none. */
bool cml_hdf5_is_foreign(const char *path);
