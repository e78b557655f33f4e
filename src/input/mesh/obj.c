/* Reads and writes OBJ files. SPDX-License-Identifier: MIT */
#include "input/mesh/obj.h"

#include "base/atomic_file.h"
#include "input/mesh/obj_scan.h"
#include "input/mesh/obj_tiny.h"

#include <stdio.h>
#include <stdlib.h>

/* Reads the corners of all faces through tinyobjloader, which resolves relative numbers. Their range is
 * checked here, with the line of the face. */
static cml_status read_corners(const struct cml_text *text, struct cml_polygons *polygons,
                               struct cml_error *err)
{
    const size_t num_corners = polygons->num_corners;
    polygons->corner = malloc(num_corners * sizeof *polygons->corner);
    if (!polygons->corner) return cml_fail_memory(err, 4.0 * (double)num_corners, "the faces of a mesh");
    if (cml_obj_tiny_corners(text->data, text->size, polygons->corner, num_corners) != num_corners)
        return cml_fail(err, CML_E_INPUT, "%s: tinyobjloader cannot read the faces", text->path);
    for (size_t f = 0, i = 0; f < polygons->num_faces; f++)
        for (size_t end = i + polygons->face_size[f]; i < end; i++)
            if (polygons->corner[i] >= polygons->num_vertices)
                return cml_fail(err, CML_E_INPUT, "%s:%d: corner of the face = %.0f (expected 1 to %zu)",
                                text->path, polygons->face_line[f], (double)polygons->corner[i] + 1,
                                polygons->num_vertices);
    return CML_OK;
}

/* The scan replaces by blanks all that it did not check, so that tinyobjloader cannot read it. */
cml_status cml_obj_read(struct cml_text *text, const struct cml_mesh_budget *budget,
                        struct cml_polygons *polygons, struct cml_error *err)
{
    CML_TRY(cml_mesh_budget_check(budget, (double)cml_obj_count(text), CML_POLYGONS_REMEDY, err));
    CML_TRY(cml_obj_scan_text(text, polygons, err));
    return read_corners(text, polygons, err);
}

/* Writes a comment, with a '#' before each of its lines. */
static void write_comment(FILE *stream, const char *comment)
{
    fputs("# ", stream);
    for (const char *c = comment; *c; c++) {
        fputc(*c, stream);
        if (*c == '\n') fputs("# ", stream);
    }
    fputc('\n', stream);
}

/* Writes a mesh as .obj with heights upwards: z changes its sign, and corners 1 and 2 change places so that
 * faces stay turned the right way. 17 digits give every double back. */
cml_status cml_obj_write(const char *path, const struct cml_mesh *mesh, const char *comment,
                         struct cml_error *err)
{
    struct cml_file file;
    CML_TRY(cml_file_create_alone(path, &file, err));
    if (comment && *comment) write_comment(file.stream, comment);
    /* 0.0 - z, because -z would turn a height of zero into -0 */
    for (size_t i = 0; i < mesh->num_vertices; i++)
        fprintf(file.stream, "v %.17g %.17g %.17g\n", mesh->vertex[i][0], mesh->vertex[i][1],
                0.0 - mesh->vertex[i][2]);
    for (size_t t = 0; t < mesh->num_triangles; t++)
        fprintf(file.stream, "f %u %u %u\n", mesh->triangle[t][0] + 1, mesh->triangle[t][2] + 1,
                mesh->triangle[t][1] + 1);
    return cml_file_commit(&file, err);
}
