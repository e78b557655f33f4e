/* Closed meshes that stand for spheres and cylinders, as OBJ files beside a test. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "lib/require.h"

#include "input/mesh/obj.h"
#include "scene/body/body_shape.h"

/* Writes the mesh of a sphere or cylinder. n: number of segments, as in cml_body_mesh. */
static inline void write_body(const char *path, struct cml_scene_body body, int n)
{
    struct cml_error err;
    struct cml_mesh mesh;
    require_ok(cml_body_mesh(&body, n, false, &mesh, &err), &err);
    require_ok(cml_obj_write(path, &mesh, NULL, &err), &err);
    cml_mesh_clear(&mesh);
}

static inline void write_sphere(const char *path, double x, double y, double z, double r, int n)
{
    write_body(path, (struct cml_scene_body){.form = CML_BODY_SPHERE, .centre = {x, y, z}, .radius = r}, n);
}
