/* Writer of XML files for VTK and ParaView: images (.vti) and faces (.vtp) with fields on their cells. The
 * header is text; the numbers follow in binary, values as 32-bit floats, points as 64-bit floats.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/field.h"
#include "base/status.h"

#include <stdint.h>

/* A grid of n[0] x n[1] x n[2] cells along x, y, z, x fastest; n[2] = 0: one flat layer of cells. */
struct cml_image {
    size_t n[3];
    double origin[3], spacing[3]; /* corner of the first cell; size of a cell */
};

/* Faces with 3 or with 4 corners each. */
struct cml_faces {
    size_t num_points, num_faces;
    int corners;
    double (*point)[3]; /* [num_points] x, y, z of each point */
    uint32_t *corner;   /* [num_faces][corners] points of each face */
};

/* Write a file atomically (atomic_file.h); CML_E_IO on failure. A field has one value per cell, or m values
 * per cell, which become m components, the component fastest. comment: letters and digits for the second
 * line, which name the run; "": none. */
CML_NODISCARD cml_status cml_vti_write(const char *path, const char *comment, const struct cml_image *image,
                                       const struct cml_field *fields, int num_fields, struct cml_error *err);
CML_NODISCARD cml_status cml_vtp_write(const char *path, const char *comment, const struct cml_faces *faces,
                                       const struct cml_field *fields, int num_fields, struct cml_error *err);

/* The first line of .vti and .vtp files, and the beginning of the line of their comment. */
#define CML_VTK_FIRST_LINE "<?xml version=\"1.0\"?>\n"
#define CML_VTK_RUN "<!-- run "

/* True if a file begins like those written here, with this comment. */
bool cml_vtk_has_comment(const char *path, const char *comment);

/* True if a file ends like those written here. */
bool cml_vtk_is_whole(const char *path);
