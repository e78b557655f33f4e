/* Reader and writer of Wavefront OBJ files: meshes of boundaries and bodies. tinyobjloader parses the faces.
 * It would turn `nan` and `0,0` into 0, and keep faces whose indices are out of range; a strict scan of the
 * text (obj_scan.h) refuses these first, with line numbers. SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "geometry/mesh.h"
#include "scene/heightmap/mesh_budget.h"

/* The axis of the file that points up. The mesh is turned by the shortest way: about the file's x axis for y,
 * -y and -z, about its y axis for x and -x. */
enum cml_up_axis { CML_UP_Z, CML_UP_MINUS_Z, CML_UP_Y, CML_UP_MINUS_Y, CML_UP_X, CML_UP_MINUS_X };

/* Changes to the coordinates of the file, in this order, and then properties of the mesh. */
struct cml_obj_options {
    enum cml_up_axis up;
    /* Degrees about the vertical axis through the file's origin, counter-clockwise seen from above. */
    double rotate;
    double unit;     /* cm per unit of the file: cm 1, mm 0.1, um 1e-4, m 100 */
    double scale;    /* factor of all coordinates, > 0 */
    double height;   /* further factor of heights, >= 0 */
    double shift[3]; /* shift along x, y and height, cm */
    double skirt;    /* width of the mesh's skirt, cm (geometry/mesh.h) */
    bool closed;     /* the mesh is that of a body, not of a boundary */
    bool unite;      /* unite the parts of a body (geometry/mesh.h) */
    enum cml_normals normals;
    struct cml_mesh_budget budget;
};

/* Reads an OBJ file `path` of `source` (NULL: the file system) as a prepared mesh in the boundary's frame: z
 * = -(Z_obj * unit * scale * height + shift_z) for up = z. CML_E_INPUT with file and line: *mesh is cleared.
 */
CML_NODISCARD cml_status cml_obj_read(const struct cml_text_source *source, const char *path,
                                      const struct cml_obj_options *options, struct cml_mesh *mesh,
                                      struct cml_mesh_notes *notes, struct cml_error *err);

/* Writes a mesh as OBJ, heights up (Z_obj = -z), with 17 digits: cml_obj_read gives the same doubles back.
 * comment: written above, each line behind a '#'; NULL: none. Atomic (base/atomic_file.h). CML_E_IO. */
CML_NODISCARD cml_status cml_obj_write(const char *path, const struct cml_mesh *mesh, const char *comment,
                                       struct cml_error *err);
