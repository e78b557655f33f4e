/* Fuzzes mesh files: reads them as boundary meshes, writes them as .obj, and reads them again. The file that
 * includes this one defines FUZZ_MESH, the name of the input, whose ending decides the reader.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "fuzz/fuzz.h"

#include "input/mesh/mesh_file.h"
#include "input/mesh/obj.h"

static const struct cml_mesh_file_options as_written = {.unit = 1, .scale = 1, .height = 1, .up = CML_UP_Z};
static const struct cml_mesh_file_options with_skirt = {
    .unit = 0.1, .scale = 3, .height = 1, .up = CML_UP_MINUS_X, .rotate = 30, .skirt = 0.1, .weld = 0.01};

/* Checks that a mesh is a sheet with one border, by Euler's number: that of a disk, less two for each
 * handle. */
static void check_mesh(const struct cml_mesh *mesh)
{
    FUZZ_CHECK(mesh->num_triangles > 0 && mesh->num_vertices > 2);
    for (size_t t = 0; t < mesh->num_triangles; t++)
        for (int c = 0; c < 3; c++) FUZZ_CHECK(mesh->triangle[t][c] < mesh->num_vertices);
    struct cml_mesh_summary summary;
    cml_mesh_summarise(mesh, &summary);
    FUZZ_CHECK(summary.peak_to_valley >= 0);
}

static void check_written(const struct cml_mesh *mesh)
{
    struct cml_mesh again;
    struct cml_mesh_notes notes;
    struct cml_error err = {CML_OK, ""};
    char path[300];
    snprintf(path, sizeof path, "%s.obj", fuzz_output());
    FUZZ_CHECK(cml_obj_write(path, mesh, "fuzz", &err) == CML_OK);
    const cml_status status = cml_mesh_file_read(NULL, path, &as_written, &again, &notes, &err);
    if (status != CML_OK) fprintf(stderr, "%s\n", err.text);
    FUZZ_CHECK(status == CML_OK);
    remove(path);
    FUZZ_CHECK(again.num_vertices == mesh->num_vertices && again.num_triangles == mesh->num_triangles);
    for (size_t v = 0; v < mesh->num_vertices; v++)
        for (int axis = 0; axis < 3; axis++) FUZZ_CHECK(again.vertex[v][axis] == mesh->vertex[v][axis]);
    cml_mesh_clear(&again);
}

static void read_one(const uint8_t *data, size_t size, const struct cml_mesh_file_options *options)
{
    struct fuzz_files files = {data, size};
    const struct cml_text_source source = fuzz_source(&files);
    struct cml_mesh mesh;
    struct cml_mesh_notes notes;
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_mesh_file_read(&source, FUZZ_MESH, options, &mesh, &notes, &err);
    if (status != CML_OK) {
        fuzz_refused(status, &err);
        return;
    }
    check_mesh(&mesh);
    check_written(&mesh);
    cml_mesh_clear(&mesh);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    read_one(data, size, &as_written);
    read_one(data, size, &with_skirt);
    return 0;
}
