/* clustermcml mesh: writes every boundary and body as an OBJ file, as Embree would get it; a drawn relief
 * also as a heightmap. SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "base/atomic_file.h"
#include "base/text.h"
#include "flights/before.h"
#include "input/mesh/gsf.h"
#include "input/mesh/obj.h"
#include "scene/body/body_shape.h"

#include <stdio.h>
#include <stdlib.h>

/* Writes one period of a drawn relief as a heightmap, which repeats as the relief does. A shift along x or y
 * is not in the file. */
static cml_status write_relief(const struct cml_options *options, const struct cml_scene *scene, int b,
                               struct cml_error *err)
{
    CML_FREED char *name = NULL, *path = NULL;
    CML_TRY(cml_text_format(&name, "a name", err, "%s.boundary%d.gsf", scene->output, b));
    CML_TRY(cml_output_path(options, name, &path, err));
    CML_TRY(cml_gsf_write(path, &scene->boundaries[b].tile, err));
    printf("boundary %d: one period as heights -> %s\n", b, path);
    return CML_OK;
}

/* Writes a boundary; a plane has no triangles and gets no file. A comment has the nominal depth, because
 * heights in the file count from it. */
static cml_status write_boundary(const struct cml_options *options, const struct cml_scene *scene, int b,
                                 struct cml_error *err)
{
    const struct cml_boundary *boundary = &scene->boundaries[b];
    CML_AT_END(cml_mesh_clear) struct cml_mesh mesh = {0};
    CML_TRY(cml_boundary_mesh(scene, b, &options->surface, &mesh, err));
    if (mesh.num_triangles == 0) {
        printf("boundary %d: plane z = %g cm, no file\n", b, boundary->z);
        return CML_OK;
    }
    CML_FREED char *name = NULL, *path = NULL;
    CML_TRY(cml_text_format(&name, "a name", err, "%s.boundary%d.obj", scene->output, b));
    CML_TRY(cml_output_path(options, name, &path, err));
    CML_TRY(cml_obj_write(path, &mesh,
                          CML_TEXT("boundary %d of %.150s, cm, heights up, nominal depth %.17g cm", b,
                                   scene->output, boundary->z),
                          err));
    printf("boundary %d: %zu triangles -> %s\n", b, mesh.num_triangles, path);
    return boundary->tile_notes.drawn.rms > 0 ? write_relief(options, scene, b, err) : CML_OK;
}

/* Writes a body. Heights count from z = 0 of the scene, as an `i` line reads them. */
static cml_status write_scene_body(const struct cml_options *options, const struct cml_scene *scene, int k,
                                   struct cml_error *err)
{
    const struct cml_scene_body *body = &scene->bodies[k];
    const double tolerance = cml_choice_tessellation(&options->surface).tolerance;
    CML_AT_END(cml_mesh_clear) struct cml_mesh mesh = {0};
    CML_FREED char *name = NULL, *path = NULL;
    CML_TRY(cml_body_mesh(body, cml_body_segments(body->form, tolerance), false, &mesh, err));
    CML_TRY(cml_text_format(&name, "a name", err, "%s.body%d.obj", scene->output, k + 1));
    CML_TRY(cml_output_path(options, name, &path, err));
    CML_TRY(cml_obj_write(path, &mesh,
                          CML_TEXT("body %d of %.150s, a %s, cm, heights up from z = 0", k + 1, scene->output,
                                   cml_body_form_name(body->form)),
                          err));
    printf("body %d: %zu triangles -> %s\n", k + 1, mesh.num_triangles, path);
    return CML_OK;
}

/* Writes all boundaries and bodies of a scene as mesh files. */
static cml_status write_scene(const struct cml_options *options, const struct cml_scene *scene,
                              struct cml_error *err)
{
    for (int b = 0; b <= scene->num_layers; b++) CML_TRY(write_boundary(options, scene, b, err));
    for (int k = 0; k < scene->num_bodies; k++) CML_TRY(write_scene_body(options, scene, k, err));
    return CML_OK;
}

/* Writes the boundaries of all runs of the file, because they may differ. */
cml_status cml_command_mesh(const struct cml_options *options, struct cml_error *err)
{
    CML_AT_END(cml_scene_list_clear) struct cml_scene_list list = {0};
    CML_TRY(cml_load_scenes(options, NULL, &list, err));
    if (options->directory) CML_TRY(cml_folder_make(options->directory, err));
    for (int i = 0; i < list.count; i++) CML_TRY(write_scene(options, &list.scenes[i], err));
    return CML_OK;
}
