/* Reader of Wavefront OBJ files as boundary meshes.
 * tinyobjloader parses; because it turns `nan` and `0,0` into 0 and keeps faces whose indices are out of
 * range, a strict scan of the text refuses these first, with line numbers. SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "geometry/mesh.h"
#include "scene/heightmap/mesh_budget.h"

/* Which axis of the file points up. The shortest turn takes it there: about the file's x axis for y, -y and
 * -z, about its y axis for x and -x. */
enum cml_up_axis { CML_UP_Z, CML_UP_MINUS_Z, CML_UP_Y, CML_UP_MINUS_Y, CML_UP_X, CML_UP_MINUS_X };

/* What is done to the file's coordinates, in this order; then what the mesh is to have. */
struct cml_obj_options {
    enum cml_up_axis up;
    double rotate;   /* degrees about the vertical through the file's origin, counter-clockwise from above */
    double unit;     /* cm per unit of the file; cm 1, mm 0.1, um 1e-4, m 100 */
    double scale;    /* > 0 */
    double height;   /* >= 0: heights are multiplied by this, too */
    double shift[3]; /* x, y, height; cm */
    double skirt;    /* cm: the mesh's (geometry/mesh.h) */
    bool closed;     /* a body, not a boundary */
    bool unite;      /* of its parts (geometry/mesh.h) */
    enum cml_normals normals;
    struct cml_mesh_budget budget;
};

/* A prepared mesh in the boundary's frame, of the file `path` of `source` (NULL: of the file system): z =
 * -(Z_obj * unit * scale * height + shift_z) for up = z. On failure (CML_E_INPUT, file and line) *mesh is
 * cleared. */
CML_NODISCARD cml_status cml_obj_read(const struct cml_text_source *source, const char *path,
                                      const struct cml_obj_options *options, struct cml_mesh *mesh,
                                      struct cml_mesh_notes *notes, struct cml_error *err);

/* Writes a mesh as OBJ, heights up (Z_obj = -z), 17 digits: cml_obj_read gives the same doubles back.
 * `comment` stands above, every line behind a '#'; NULL: none. Atomic (text.h); CML_E_IO on failure. */
CML_NODISCARD cml_status cml_obj_write(const char *path, const struct cml_mesh *mesh, const char *comment,
                                       struct cml_error *err);
