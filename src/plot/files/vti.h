/* Reader of flat maps from VTK image files (.vti), as vtk.h writes them: raw appended data behind a UInt64,
 * Float32 values on cells, one piece, not compressed. Blanks, order of attributes, and arrays that nobody
 * asks for do not matter; what is not as it says is refused. SPDX-License-Identifier: MIT */
#ifndef CML_VTI_H
#define CML_VTI_H

#include "base/status.h"

#include <stddef.h>

/* n[0] x n[1] pixels along x and y, x fastest; lengths in cm. */
struct cml_pixels {
    size_t n[2];
    double origin[2], spacing[2]; /* corner of the first pixel, size of a pixel */
    float *value;                 /* [n[1]][n[0]], finite, >= 0, owned */
};

/* Reads the array of this name. CML_E_INPUT with file and line; then *pixels is cleared. Memory is asked for
 * only when the file holds as many values. The caller frees it with cml_pixels_clear. */
CML_NODISCARD cml_status cml_vti_read(const char *path, const char *name, struct cml_pixels *pixels,
                                      struct cml_error *err);

void cml_pixels_clear(struct cml_pixels *pixels);

#endif
