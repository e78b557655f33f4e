/* Makes the surfaces, trees and grids of a scene's bodies. SPDX-License-Identifier: MIT */
#include "surface/body/body_surface.h"

#include "base/constants.h"
#include "base/shared.h"
#include "geometry/vec3.h"
#include "scene/body/body_place.h"
#include "scene/body/body_shape.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* Makes a copy of the body's mesh in the frame of its layer, and the surface for its queries. */
static cml_status make_mesh(const double origin[2], const struct cml_scene_body *body, double depth,
                            enum cml_mesh_search search, struct cml_body_surface *surface,
                            struct cml_error *err)
{
    CML_AT_END(cml_mesh_clear) struct cml_mesh mesh = {0};
    CML_TRY(cml_mesh_copy(&body->mesh, &mesh, err));
    for (size_t i = 0; i < mesh.num_vertices; i++) mesh.vertex[i][2] -= depth;
    mesh.lower[2] -= depth;
    mesh.upper[2] -= depth;
    mesh.z_border -= depth;
    return cml_mesh_surface_create(&mesh, origin[0], origin[1], search, &surface->mesh, err);
}

/* Smallest half width of a body, in steps of single precision at its largest coordinate. From this size on,
 * spheres and cylinders give the results of exact ones (cross.small_bodies); meshes did so from 30 steps
 * on. */
#define LEAST_ROUNDINGS 32

/* Finds half the smallest width of the boxes around the parts of a mesh, cm. */
static cml_status size_of_parts(const struct cml_mesh *mesh, double *size, struct cml_error *err)
{
    CML_FREED double(*box)[2][3] = malloc(mesh->num_parts * sizeof *box);
    if (!box) return cml_fail_memory(err, (double)(mesh->num_parts * sizeof *box), "the parts of a body");
    for (size_t k = 0; k < mesh->num_parts; k++)
        for (int i = 0; i < 3; i++)
            box[k][0][i] = box[k][1][i] = mesh->vertex[mesh->triangle[mesh->part_start[k]][0]][i];
    for (size_t c = 0; c < 3 * mesh->num_triangles; c++) {
        double(*own)[3] = box[mesh->part[c / 3]];
        for (int i = 0; i < 3; i++) {
            own[0][i] = fmin(own[0][i], mesh->vertex[mesh->triangle[c / 3][c % 3]][i]);
            own[1][i] = fmax(own[1][i], mesh->vertex[mesh->triangle[c / 3][c % 3]][i]);
        }
    }
    *size = INFINITY;
    for (size_t k = 0; k < mesh->num_parts; k++)
        for (int i = 0; i < 3; i++) *size = fmin(*size, 0.5 * (box[k][1][i] - box[k][0][i]));
    return CML_OK;
}

/* Refuses a body smaller than LEAST_ROUNDINGS steps of single precision. All engines refuse the same bodies,
 * also those that compute in double. */
static cml_status check_size(const struct cml_scene *scene, const double origin[2], int k,
                             const struct cml_body_surface *surface, struct cml_error *err)
{
    const struct cml_scene_body *body = &scene->bodies[k];
    const double *lower = surface->lower, *upper = surface->upper, from[3] = {origin[0], origin[1], 0};
    double farthest = 0, size = body->radius;
    const char *what = body->form != CML_BODY_MESH ? "radius"
                       : body->mesh.num_parts > 1  ? "half a width of a part"
                                                   : "half a width";
    for (int i = 0; i < 3; i++)
        farthest = fmax(farthest, fmax(fabs(lower[i] - from[i]), fabs(upper[i] - from[i])));
    if (body->form == CML_BODY_MESH) CML_TRY(size_of_parts(&body->mesh, &size, err));
    if (body->form == CML_BODY_CYLINDER && 0.5 * cml_body_convex(body).length < size) {
        size = 0.5 * cml_body_convex(body).length;
        what = "half the length";
    }
    const double step = FLT_EPSILON * farthest, least = LEAST_ROUNDINGS * step;
    if (size >= least) return CML_OK;
    /* 1.005: %.3g must not round below the least size */
    return cml_fail(err, CML_E_INPUT,
                    "%s:%d: body %d: %s = %g cm (expected at least %.3g cm: single precision has steps of "
                    "%.2g cm there, %.3g cm away from the origin of the scene or the top of the layer)",
                    scene->file, body->line, k + 1, what, size, 1.005 * least, step, farthest);
}

/* Makes the surface of body k. Depths count from the frame of the body's layer, as in the kernels. */
static cml_status make_surface(const struct cml_scene *scene, const double origin[2], int k, double depth,
                               enum cml_mesh_search search, struct cml_body_surface *surface,
                               struct cml_error *err)
{
    static const enum cml_surface_kind kinds[] = {CML_SURFACE_MESH, CML_SURFACE_SPHERE, CML_SURFACE_CYLINDER};
    static const uint64_t facets[] = {0, 1, 3};
    const struct cml_scene_body *body = &scene->bodies[k];
    surface->kind = kinds[body->form];
    surface->depth = depth;
    cml_body_box(body, surface->lower, surface->upper);
    surface->lower[2] -= depth;
    surface->upper[2] -= depth;
    CML_TRY(check_size(scene, origin, k, surface, err));
    surface->primitives = body->form == CML_BODY_MESH ? body->mesh.num_triangles : facets[body->form];
    surface->first = k > 0 ? surface[-1].first + surface[-1].primitives : 0;
    return body->form == CML_BODY_MESH ? make_mesh(origin, body, depth, search, surface, err) : CML_OK;
}

/* Makes a tree for every medium in which bodies lie, their host. A packet in a medium meets the bodies of
 * which the medium is the host. Inside a body it also meets that body itself, which needs no tree. */
static cml_status make_tree(const struct cml_scene *scene, struct cml_body_surfaces *surfaces,
                            struct cml_error *err)
{
    const size_t n = (size_t)scene->num_bodies;
    CML_FREED double(*boxes)[2][3] = malloc(n * sizeof *boxes);
    CML_FREED int *host = malloc(n * sizeof *host);
    if (!boxes || !host) return cml_fail_memory(err, (double)(n * sizeof *boxes), "the tree of bodies");
    for (size_t k = 0; k < n; k++) {
        cml_vec3_copy(surfaces->item[k].lower, boxes[k][0]);
        cml_vec3_copy(surfaces->item[k].upper, boxes[k][1]);
        host[k] = scene->bodies[k].host;
    }
    return cml_body_tree_create((const double(*)[2][3])boxes, host, (int)n, scene->num_layers + 2 + (int)n,
                                &surfaces->tree, err);
}

/* Makes the grids. `depths` is indexed by layer, but the grids need depths by medium: a body has the frame of
 * its layer. */
static cml_status make_grids(const struct cml_scene *scene, const double origin[2], const double *depths,
                             struct cml_body_surfaces *surfaces, struct cml_error *err)
{
    const size_t media = (size_t)scene->num_layers + 2 + (size_t)scene->num_bodies;
    CML_FREED double *depth = calloc(media, sizeof *depth);
    if (!depth) return cml_fail_memory(err, (double)(media * sizeof *depth), "the bounds of bodies");
    for (int l = 1; l <= scene->num_layers; l++) depth[l] = depths[l - 1];
    for (int k = 0; k < scene->num_bodies; k++)
        depth[cml_body_medium(scene, k)] = depths[scene->bodies[k].layer - 1];
    return cml_body_grids_create(scene, origin, depth, &surfaces->grids, err);
}

/* Makes the surfaces, the trees and the grids of the scene's bodies. After a failure *surfaces must be
 * freed. */
static cml_status create(const struct cml_scene *scene, const double origin[2], const double *depths,
                         enum cml_mesh_search search, struct cml_body_surfaces *surfaces,
                         struct cml_error *err)
{
    for (int k = 0; k < surfaces->count; k++)
        CML_TRY(make_surface(scene, origin, k, depths[scene->bodies[k].layer - 1], search, &surfaces->item[k],
                             err));
    CML_TRY(make_tree(scene, surfaces, err));
    return make_grids(scene, origin, depths, surfaces, err);
}

/* Makes a copy of all bodies in which each is a mesh that deviates by at most the share `tolerance` of its
 * radius. */
static cml_status tessellate(const struct cml_scene *scene, double tolerance, struct cml_scene_body *bodies,
                             struct cml_error *err)
{
    for (int k = 0; k < scene->num_bodies; k++) {
        const struct cml_scene_body *from = &scene->bodies[k];
        bodies[k] = *from;
        bodies[k].form = CML_BODY_MESH;
        bodies[k].mesh = (struct cml_mesh){0};
        CML_TRY(cml_body_mesh(from, cml_body_segments(from->form, tolerance), false, &bodies[k].mesh, err));
    }
    return CML_OK;
}

/* Makes the surfaces of tessellated bodies. Meshes may touch where the bodies themselves do not, so they are
 * placed and checked anew. */
static cml_status create_tessellated(const struct cml_scene *scene, const double origin[2],
                                     const double *depths, double tolerance, enum cml_mesh_search search,
                                     struct cml_body_surfaces *surfaces, struct cml_error *err)
{
    struct cml_scene meshes = *scene;
    meshes.bodies = calloc((size_t)scene->num_bodies, sizeof *meshes.bodies);
    if (!meshes.bodies)
        return cml_fail_memory(err, scene->num_bodies * (double)sizeof *meshes.bodies, "bodies");
    cml_status status = tessellate(scene, tolerance, meshes.bodies, err);
    if (status == CML_OK) status = cml_scene_place_bodies(&meshes, err);
    if (status == CML_OK) status = cml_scene_check_bodies(&meshes, err);
    if (status == CML_OK) status = create(&meshes, origin, depths, search, surfaces, err);
    for (int k = 0; k < scene->num_bodies; k++) cml_mesh_clear(&meshes.bodies[k].mesh);
    free(meshes.bodies);
    return status;
}

cml_status cml_body_surfaces_create(const struct cml_scene *scene, const double origin[2],
                                    const double *depths, double tolerance, enum cml_mesh_search search,
                                    struct cml_body_surfaces *surfaces, struct cml_error *err)
{
    *surfaces = (struct cml_body_surfaces){.count = scene->num_bodies, .of = scene->bodies};
    if (scene->num_bodies == 0) return CML_OK;
    surfaces->item = calloc((size_t)scene->num_bodies, sizeof *surfaces->item);
    if (!surfaces->item)
        return cml_fail_memory(err, scene->num_bodies * (double)sizeof *surfaces->item, "bodies");
    cml_status status = cml_share_begin(&surfaces->users, err);
    if (status == CML_OK)
        status = tolerance > 0 ? create_tessellated(scene, origin, depths, tolerance, search, surfaces, err)
                               : create(scene, origin, depths, search, surfaces, err);
    if (status != CML_OK) cml_body_surfaces_free(surfaces);
    return status;
}

void cml_body_surfaces_share(const struct cml_body_surfaces *from, struct cml_body_surfaces *surfaces)
{
    *surfaces = *from;
    cml_share(surfaces->users);
}

void cml_body_surfaces_free(struct cml_body_surfaces *surfaces)
{
    if (cml_share_end(surfaces->users)) {
        for (int k = 0; surfaces->item && k < surfaces->count; k++)
            cml_mesh_surface_free(surfaces->item[k].mesh);
        free(surfaces->item);
        cml_body_tree_clear(&surfaces->tree);
        cml_body_grids_clear(&surfaces->grids);
    }
    *surfaces = (struct cml_body_surfaces){0};
}

/* A sphere has one facet; a cylinder has three: facet 0 is its side, the others are its ends. */
double cml_body_facet_area(const struct cml_body_surface *surface, const struct cml_scene_body *body,
                           size_t facet)
{
    const double r = body->radius;
    if (surface->kind == CML_SURFACE_MESH) return cml_mesh_surface_area(surface->mesh, facet);
    if (body->form == CML_BODY_SPHERE) return 4 * CML_PI * r * r;
    return facet == 0 ? 2 * CML_PI * r * cml_body_convex(body).length : CML_PI * r * r;
}
