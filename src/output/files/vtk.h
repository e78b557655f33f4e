/* Writer of VTK's XML files for ParaView and VTK: images (.vti) and faces (.vtp) with fields on their cells.
 * Raw appended data: the header is text, the numbers follow in binary, values as 32-bit floats, points as
 * 64-bit.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/field.h"
#include "base/status.h"

#include <stdint.h>

/* n[0] n[1] n[2] cells along x, y, z, x fastest; n[2] = 0: one flat layer of cells. */
struct cml_image {
    size_t n[3];
    double origin[3], spacing[3]; /* corner of the first cell, size of a cell */
};

/* Faces of three or four corners each. */
struct cml_faces {
    size_t num_points, num_faces;
    int corners;
    double (*point)[3]; /* [num_points] */
    uint32_t *corner;   /* [num_faces][corners] */
};

/* cml_vti_write and cml_vtp_write write atomically (atomic_file.h); CML_E_IO on failure. A field has as many
 * values as there are cells, or a multiple: then so many components per cell, the component fastest.
 * comment: some letters and digits for the second line, which says of which run the file is; "": none. */
CML_NODISCARD cml_status cml_vti_write(const char *path, const char *comment, const struct cml_image *image,
                                       const struct cml_field *fields, int num_fields, struct cml_error *err);
CML_NODISCARD cml_status cml_vtp_write(const char *path, const char *comment, const struct cml_faces *faces,
                                       const struct cml_field *fields, int num_fields, struct cml_error *err);

/* The first line of these files, and the begin of the line of the comment. */
#define CML_VTK_FIRST_LINE "<?xml version=\"1.0\"?>\n"
#define CML_VTK_RUN "<!-- run "

/* Whether a file begins as these with that comment. */
bool cml_vtk_has_comment(const char *path, const char *comment);

/* Whether a file ends as these do. */
bool cml_vtk_is_whole(const char *path);
