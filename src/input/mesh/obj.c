/* Reads and writes OBJ files: cuts faces into triangles, and turns axes and units into those of the program.
 * SPDX-License-Identifier: MIT */
#include "input/mesh/obj.h"

#include "base/atomic_file.h"
#include "base/constants.h"
#include "input/mesh/obj_polygon.h"
#include "input/mesh/obj_scan.h"
#include "input/mesh/obj_tiny.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Reads the corners of all faces through tinyobjloader, which resolves relative numbers. Their range is
 * checked here, with the line of the face. */
static cml_status read_corners(const struct cml_text *text, const struct cml_obj_scan *scan, uint32_t *corner,
                               struct cml_error *err)
{
    const size_t count = cml_obj_tiny_corners(text->data, text->size, corner, scan->num_corners);
    if (count != scan->num_corners)
        return cml_fail(err, CML_E_INPUT, "%s: tinyobjloader cannot read the faces", text->path);
    for (size_t f = 0, i = 0; f < scan->num_faces; f++)
        for (size_t end = i + scan->face_size[f]; i < end; i++)
            if (corner[i] >= scan->num_vertices)
                return cml_fail(err, CML_E_INPUT, "%s:%d: corner of the face = %.0f (expected 1 to %zu)",
                                text->path, scan->face_line[f], (double)corner[i] + 1, scan->num_vertices);
    return CML_OK;
}

/* Faces whose corners do not lie in one plane. */
struct bent_faces {
    size_t count;
    double most; /* largest distance of a corner from its face's mean plane, in units of the file */
};

/* Splits a face with more than three corners into triangles, and refuses one that is not convex. A triangle,
 * the usual case, is copied. */
static cml_status split_face(const char *path, const struct cml_obj_scan *scan, size_t face,
                             const uint32_t *corner, uint32_t (*triangle)[3], struct bent_faces *bent,
                             struct cml_error *err)
{
    const uint32_t size = scan->face_size[face];
    if (size == 3) {
        memcpy(triangle[0], corner, sizeof triangle[0]);
        return CML_OK;
    }
    if (size > CML_OBJ_MAX_CORNERS)
        return cml_fail(err, CML_E_INPUT, "%s:%d: the face has %u corners (expected 3 to %d)", path,
                        scan->face_line[face], size, CML_OBJ_MAX_CORNERS);
    double bend = 0;
    const char *why = cml_obj_split((const double(*)[3])scan->vertex, corner, size, triangle, &bend);
    bent->count += bend > 0;
    bent->most = fmax(bent->most, bend);
    if (!why) return CML_OK;
    return cml_fail(
        err, CML_E_INPUT,
        "%s:%d: the face %s (expected a triangle or a convex polygon; triangulate it when exporting)", path,
        scan->face_line[face], why);
}

/* Splits all faces. The two last corners of a triangle are exchanged, because turning heights into depths (z
 * down) mirrors the mesh. */
static cml_status split_faces(const char *path, const struct cml_obj_scan *scan, const uint32_t *corner,
                              struct cml_mesh *mesh, int *triangle_line, struct bent_faces *bent,
                              struct cml_error *err)
{
    for (size_t f = 0; f < scan->num_faces; corner += scan->face_size[f++]) {
        const size_t begin = mesh->num_triangles;
        CML_TRY(split_face(path, scan, f, corner, mesh->triangle + begin, bent, err));
        mesh->num_triangles += scan->face_size[f] - 2;
        for (size_t t = begin; t < mesh->num_triangles; t++) {
            const uint32_t second = mesh->triangle[t][1];
            mesh->triangle[t][1] = mesh->triangle[t][2];
            mesh->triangle[t][2] = second;
            triangle_line[t] = scan->face_line[f];
        }
    }
    return CML_OK;
}

/* Makes the triangles of all faces: a polygon of n corners becomes n - 2 triangles. */
static cml_status build_triangles(const struct cml_text *text, const struct cml_obj_scan *scan,
                                  struct cml_mesh *mesh, int **triangle_line, struct bent_faces *bent,
                                  struct cml_error *err)
{
    const size_t count = scan->num_corners - 2 * scan->num_faces;
    uint32_t *corner = malloc(scan->num_corners * sizeof *corner);
    mesh->triangle = malloc(count * sizeof *mesh->triangle);
    *triangle_line = malloc(count * sizeof **triangle_line);
    cml_status status = CML_OK;
    if (!corner || !mesh->triangle || !*triangle_line)
        status = cml_fail_memory(err, 28.0 * (double)scan->num_corners, "the faces of a mesh");
    if (status == CML_OK) status = read_corners(text, scan, corner, err);
    if (status == CML_OK) status = split_faces(text->path, scan, corner, mesh, *triangle_line, bent, err);
    free(corner);
    return status;
}

/* Turns the axes of the file to x, y, height. All turns are rotations, which mirror nothing. */
static void turn_axes(enum cml_up_axis up, const double file[3], double out[3])
{
    const double x = file[0], y = file[1], z = file[2];
    const double turned[6][3] = {
        [CML_UP_Z] = {x, y, z},        [CML_UP_MINUS_Z] = {x, -y, -z}, [CML_UP_Y] = {x, -z, y},
        [CML_UP_MINUS_Y] = {x, z, -y}, [CML_UP_X] = {-z, y, x},        [CML_UP_MINUS_X] = {z, y, -x},
    };
    memcpy(out, turned[up], sizeof turned[up]);
}

/* Finds the cosine and sine of an angle in degrees, exact for multiples of 90. */
static void find_turn(double degrees, double turn[2])
{
    const double quarters = round(degrees / 90), rest = (degrees - 90 * quarters) * (CML_PI / 180);
    const double c = cos(rest), s = sin(rest);
    const double turned[4][2] = {{c, s}, {-s, c}, {-c, -s}, {s, -c}};
    const int quarter = (int)(quarters - 4 * floor(quarters / 4));
    memcpy(turn, turned[quarter], sizeof turned[quarter]);
}

/* Moves the vertices into the boundary's frame: axes, rotation, scale, shift, then depth instead of height.
 */
static void place_vertices(struct cml_mesh *mesh, const struct cml_obj_options *options)
{
    const double along = options->unit * options->scale;
    const double factor[3] = {along, along, along * options->height};
    double turn[2];
    find_turn(options->rotate, turn);
    for (size_t i = 0; i < mesh->num_vertices; i++) {
        double turned[3];
        turn_axes(options->up, mesh->vertex[i], turned);
        const double x = turned[0], y = turned[1];
        turned[0] = turn[0] * x - turn[1] * y;
        turned[1] = turn[1] * x + turn[0] * y;
        for (int k = 0; k < 3; k++) mesh->vertex[i][k] = turned[k] * factor[k] + options->shift[k];
        mesh->vertex[i][2] = -mesh->vertex[i][2];
    }
}

/* Makes the mesh. The vertices move from the scan into it, so that a large file is never in memory twice. */
static cml_status build_mesh(struct cml_text *text, struct cml_obj_scan *scan,
                             const struct cml_obj_options *options, struct cml_mesh *mesh,
                             struct cml_mesh_notes *notes, struct cml_error *err)
{
    int *triangle_line = NULL;
    struct bent_faces bent = {0};
    CML_TRY(cml_mesh_budget_check(&options->budget, (double)cml_obj_count(text),
                                  "a coarser mesh or a larger --mesh-budget", err));
    CML_TRY(cml_obj_scan_text(text, scan, err));
    cml_status status = build_triangles(text, scan, mesh, &triangle_line, &bent, err);
    if (status == CML_OK) {
        mesh->vertex = scan->vertex;
        mesh->num_vertices = scan->num_vertices;
        mesh->normals = options->normals;
        mesh->skirt = options->skirt;
        mesh->closed = options->closed;
        mesh->unite = options->unite;
        scan->vertex = NULL;
        place_vertices(mesh, options);
        const struct cml_mesh_source source = {
            .path = text->path, .vertex_line = scan->vertex_line, .triangle_line = triangle_line};
        status = cml_mesh_prepare(mesh, &source, notes, err);
        if (notes) notes->bent = bent.count;
        if (notes) notes->bend = bent.most * options->unit * options->scale;
    }
    free(triangle_line);
    return status;
}

/* Reads a mesh from an .obj file. Our own scan checks every line strictly and blanks the rest, so that
 * tinyobjloader reads nothing unchecked. */
cml_status cml_obj_read(const struct cml_text_source *source, const char *path,
                        const struct cml_obj_options *options, struct cml_mesh *mesh,
                        struct cml_mesh_notes *notes, struct cml_error *err)
{
    struct cml_text text;
    struct cml_obj_scan scan = {0};
    *mesh = (struct cml_mesh){0};
    CML_TRY(cml_text_read(source, path, &text, err));
    const cml_status status = build_mesh(&text, &scan, options, mesh, notes, err);
    cml_obj_scan_clear(&scan);
    cml_text_clear(&text);
    if (status != CML_OK) cml_mesh_clear(mesh);
    return status;
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
