/* Reader of the head of an .h5 file: which run it belongs to, and whether the file is damaged.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* Begins the attribute `source` of every file that the program writes. */
#define CML_HDF5_SOURCE "clustermcml: "

struct cml_hdf5_head {
    double photons;
    char identity[17]; /* identity of the run, 16 digits; "": the file has none */
    bool has_totals;   /* true for the result of a run, false for a file of saved packets */
};

/* Reads the attributes `photons` and `identity` of a file that cml_hdf5_write has written. False: there is no
 * such file, it is damaged, or the program has no HDF5. Compared are the size of the file with its superblock
 * (so a cut file is refused), the checksums of superblock, attributes and headers of data sets, and the
 * checksums of chunks of `arrays` and of their errors; the file need not have these arrays. Not noticed are
 * changes in other arrays, in numbers that are not deflated (saved packets), in the texts of the call, and in
 * bytes that nothing uses. */
bool cml_hdf5_read_head(const char *path, const char *const *arrays, int count, struct cml_hdf5_head *head);

/* True if the path leads to a sound HDF5 file of another program: HDF5 opens the file, and no attribute
 * `source` at its root begins with CML_HDF5_SOURCE. A program without HDF5 knows none. */
bool cml_hdf5_is_foreign(const char *path);
