/* Makes prepared meshes of the polygons of mesh files: cuts the polygons into triangles, and turns axes and
 * units into those of the program. SPDX-License-Identifier: MIT */
#include "input/mesh/mesh_file.h"

#include "base/constants.h"
#include "input/mesh/obj.h"
#include "input/mesh/ply.h"
#include "input/mesh/polygon_split.h"
#include "input/mesh/polygons.h"
#include "input/mesh/stl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Faces whose corners do not lie in one plane. */
struct bent_faces {
    size_t count;
    double most; /* largest distance of a corner from its face's mean plane, in units of the file */
};

/* Refuses a face. Names its line, or its number in a binary file. */
static cml_status fail_face(const char *path, const struct cml_polygons *polygons, size_t face,
                            const char *why, const char *expected, struct cml_error *err)
{
    if (polygons->face_line)
        return cml_fail(err, CML_E_INPUT, "%s:%d: the face %s (expected %s)", path, polygons->face_line[face],
                        why, expected);
    return cml_fail(err, CML_E_INPUT, "%s: face %zu: the face %s (expected %s)", path, face + 1, why,
                    expected);
}

/* Splits a face into triangles. A triangle, the usual case, is copied. */
static cml_status split_face(const char *path, const struct cml_polygons *polygons, size_t face,
                             const uint32_t *corner, uint32_t (*triangle)[3], struct bent_faces *bent,
                             struct cml_error *err)
{
    const uint32_t size = polygons->face_size[face];
    if (size == 3) {
        memcpy(triangle[0], corner, sizeof triangle[0]);
        return CML_OK;
    }
    if (size > CML_POLYGON_MAX_CORNERS)
        return fail_face(path, polygons, face, CML_TEXT("has %u corners", size),
                         CML_TEXT("3 to %d", CML_POLYGON_MAX_CORNERS), err);
    double bend = 0;
    const char *why = cml_polygon_split((const double(*)[3])polygons->vertex, corner, size, triangle, &bend);
    bent->count += bend > 0;
    bent->most = fmax(bent->most, bend);
    if (!why) return CML_OK;
    return fail_face(path, polygons, face, why,
                     "a triangle or a convex polygon; triangulate it when exporting", err);
}

/* Splits all faces. The two last corners of a triangle are exchanged, because turning heights into depths (z
 * down) mirrors the mesh. triangle_line: NULL for a binary file. */
static cml_status split_faces(const char *path, const struct cml_polygons *polygons, struct cml_mesh *mesh,
                              int *triangle_line, struct bent_faces *bent, struct cml_error *err)
{
    const uint32_t *corner = polygons->corner;
    for (size_t f = 0; f < polygons->num_faces; corner += polygons->face_size[f++]) {
        const size_t begin = mesh->num_triangles;
        CML_TRY(split_face(path, polygons, f, corner, mesh->triangle + begin, bent, err));
        mesh->num_triangles += polygons->face_size[f] - 2;
        for (size_t t = begin; t < mesh->num_triangles; t++) {
            const uint32_t second = mesh->triangle[t][1];
            mesh->triangle[t][1] = mesh->triangle[t][2];
            mesh->triangle[t][2] = second;
            if (triangle_line) triangle_line[t] = polygons->face_line[f];
        }
    }
    return CML_OK;
}

/* Makes the triangles of all faces: a polygon of n corners becomes n - 2 triangles. */
static cml_status build_triangles(const char *path, const struct cml_polygons *polygons,
                                  struct cml_mesh *mesh, int **triangle_line, struct bent_faces *bent,
                                  struct cml_error *err)
{
    const size_t count = polygons->num_corners - 2 * polygons->num_faces;
    if (count == 0) return cml_fail(err, CML_E_INPUT, "%s: no faces (expected one or more)", path);
    if (polygons->num_vertices >= UINT32_MAX || polygons->num_corners >= UINT32_MAX)
        return cml_fail(err, CML_E_INPUT, "%s: too many vertices or faces (expected fewer than 2^32)", path);
    mesh->triangle = malloc(count * sizeof *mesh->triangle);
    if (polygons->face_line) *triangle_line = malloc(count * sizeof **triangle_line);
    if (!mesh->triangle || (polygons->face_line && !*triangle_line))
        return cml_fail_memory(err, 16.0 * (double)count, "the faces of a mesh");
    return split_faces(path, polygons, mesh, *triangle_line, bent, err);
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

/* Returns cosine and sine of an angle in degrees, exact for multiples of 90. */
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
static void place_vertices(struct cml_mesh *mesh, const struct cml_mesh_file_options *options)
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

/* Makes the mesh of the polygons. The vertices move into the mesh, and the other arrays are freed early, so
 * that a large file is never in memory twice. */
static cml_status build_mesh(const char *path, struct cml_polygons *polygons,
                             const struct cml_mesh_file_options *options, struct cml_mesh *mesh,
                             struct cml_mesh_notes *notes, struct cml_error *err)
{
    struct bent_faces bent = {0};
    CML_FREED int *triangle_line = NULL;
    CML_TRY(build_triangles(path, polygons, mesh, &triangle_line, &bent, err));
    CML_FREED int *vertex_line = polygons->vertex_line;
    mesh->vertex = polygons->vertex;
    mesh->num_vertices = polygons->num_vertices;
    polygons->vertex = NULL;
    polygons->vertex_line = NULL;
    cml_polygons_clear(polygons);
    mesh->normals = options->normals;
    mesh->weld = options->weld;
    mesh->skirt = options->skirt;
    mesh->closed = options->closed;
    mesh->unite = options->unite;
    place_vertices(mesh, options);
    const struct cml_mesh_source source = {
        .path = path, .vertex_line = vertex_line, .triangle_line = triangle_line};
    const cml_status status = cml_mesh_prepare(mesh, &source, notes, err);
    if (notes) notes->bent = bent.count;
    if (notes) notes->bend = bent.most * options->unit * options->scale;
    return status;
}

/* Formats of mesh files. `read` makes polygons of a whole file in memory. */
static const struct format {
    const char *ending;
    cml_status (*load)(const struct cml_text_source *source, const char *path, struct cml_text *text,
                       struct cml_error *err);
    cml_status (*read)(struct cml_text *text, const struct cml_mesh_budget *budget,
                       struct cml_polygons *polygons, struct cml_error *err);
} formats[] = {
    {".obj", cml_text_read, cml_obj_read},
    {".stl", cml_text_read_bytes, cml_stl_read},
    {".ply", cml_text_read_bytes, cml_ply_read},
};

static const struct format *find_format(const char *name)
{
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (cml_file_ends_in(name, formats[i].ending)) return &formats[i];
    return NULL;
}

bool cml_mesh_file_is_known(const char *name)
{
    return find_format(name) != NULL;
}

/* Reads the polygons of a file. The bytes of the file are freed before the mesh is made. */
static cml_status read_polygons(const struct cml_text_source *source, const char *path,
                                const struct cml_mesh_budget *budget, struct cml_polygons *polygons,
                                struct cml_error *err)
{
    const struct format *format = find_format(path);
    if (!format) return cml_fail_field(err, path, 0, "file", path, "an " CML_MESH_FILE_ENDINGS " file");
    CML_AT_END(cml_text_clear) struct cml_text text = {0};
    struct cml_mesh_budget ours = *budget;
    CML_TRY(format->load(source, path, &text, err));
    ours.read = (double)text.size;
    return format->read(&text, &ours, polygons, err);
}

cml_status cml_mesh_file_read(const struct cml_text_source *source, const char *path,
                              const struct cml_mesh_file_options *options, struct cml_mesh *mesh,
                              struct cml_mesh_notes *notes, struct cml_error *err)
{
    CML_AT_END(cml_polygons_clear) struct cml_polygons polygons = {0};
    *mesh = (struct cml_mesh){0};
    cml_status status = read_polygons(source, path, &options->budget, &polygons, err);
    if (status == CML_OK) status = build_mesh(path, &polygons, options, mesh, notes, err);
    if (status != CML_OK) cml_mesh_clear(mesh);
    return status;
}
