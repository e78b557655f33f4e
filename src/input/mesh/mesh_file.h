/* Reader of mesh files: meshes of boundaries and bodies. The ending of a file's name decides its format.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/text.h"
#include "geometry/mesh.h"
#include "scene/heightmap/mesh_budget.h"

/* The axis of the file that points up. The mesh is turned by the shortest way: about the file's x axis for y,
 * -y and -z, about its y axis for x and -x. */
enum cml_up_axis { CML_UP_Z, CML_UP_MINUS_Z, CML_UP_Y, CML_UP_MINUS_Y, CML_UP_X, CML_UP_MINUS_X };

/* Changes to the coordinates of the file, in this order, and then properties of the mesh. */
struct cml_mesh_file_options {
    enum cml_up_axis up;
    /* Degrees about the vertical axis through the file's origin, counter-clockwise seen from above. */
    double rotate;
    double unit;     /* cm per unit of the file: cm 1, mm 0.1, um 1e-4, m 100 */
    double scale;    /* factor of all coordinates, > 0 */
    double height;   /* further factor of heights, >= 0 */
    double shift[3]; /* shift along x, y and height, cm */
    double weld;     /* corners nearer than this are joined, cm; 0: equal ones only (geometry/mesh.h) */
    double skirt;    /* width of the mesh's skirt, cm (geometry/mesh.h) */
    bool closed;     /* the mesh is that of a body, not of a boundary */
    bool unite;      /* unite the parts of a body (geometry/mesh.h) */
    enum cml_normals normals;
    struct cml_mesh_budget budget;
};

/* Names of the formats, for messages. */
#define CML_MESH_FILE_ENDINGS ".obj, .stl or .ply"

/* True if the ending of the name is that of a format which cml_mesh_file_read reads. */
bool cml_mesh_file_is_known(const char *name);

/* Reads a file `path` of `source` (NULL: the file system) as a prepared mesh in the boundary's frame: z =
 * -(z_file * unit * scale * height + shift_z) for up = z. Polygons are cut into triangles. CML_E_INPUT with
 * file and line, or byte: *mesh is cleared. */
CML_NODISCARD cml_status cml_mesh_file_read(const struct cml_text_source *source, const char *path,
                                            const struct cml_mesh_file_options *options,
                                            struct cml_mesh *mesh, struct cml_mesh_notes *notes,
                                            struct cml_error *err);
