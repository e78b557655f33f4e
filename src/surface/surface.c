/* Represents each boundary of a scene: plane, cones, mesh or repeated mesh. SPDX-License-Identifier: MIT */
#include "surface/surface.h"

#include "base/clock.h"
#include "base/shared.h"
#include "geometry/vec3.h"
#include "scene/radial.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

const char *cml_surface_kind_name(enum cml_surface_kind kind)
{
    static const char *const names[] = {"plane", "cone", "mesh", "auto", "sphere", "cylinder"};
    return names[kind];
}

/* Makes *def a plane at a scene depth, cm. */
static void make_plane(double depth, const char *reason, struct cml_surface_def *def)
{
    def->kind = CML_SURFACE_PLANE;
    def->depth = depth;
    def->primitives = 1;
    snprintf(def->reason, sizeof def->reason, "%s", reason);
}

/* Makes rings of cones from a radial heightfield: z = -h at each ring, and the slope dz/dr to the next ring,
 * 0 behind the last one. */
static cml_status make_cones(const struct cml_radial *field, int given, double depth,
                             struct cml_surface_def *def, struct cml_error *err)
{
    const size_t n = (size_t)field->n;
    def->kind = CML_SURFACE_CONE;
    def->depth = depth;
    def->num_rings = field->n;
    def->primitives = n;
    def->expectation = cml_choice_expect_cones(field->n);
    def->r = malloc(3 * n * sizeof *def->r);
    if (!def->r) return cml_fail_memory(err, (double)(3 * n * sizeof *def->r), "the rings of a heightfield");
    def->z = def->r + n;
    def->slope = def->z + n;
    def->lowest = def->highest = -field->h[0];
    for (size_t i = 0; i < n; i++) {
        def->r[i] = field->r[i];
        def->z[i] = -field->h[i];
        def->slope[i] = i + 1 < n ? -(field->h[i + 1] - field->h[i]) / (field->r[i + 1] - field->r[i]) : 0;
        def->lowest = fmin(def->lowest, def->z[i]);
        def->highest = fmax(def->highest, def->z[i]);
        def->steepest = fmax(def->steepest, fabs(def->slope[i]));
    }
    if (field->n == given)
        snprintf(def->reason, sizeof def->reason, "radial heightfield: exact cones");
    else
        snprintf(def->reason, sizeof def->reason,
                 "radial heightfield: exact cones, %d collinear samples merged", given - field->n);
    return cml_depth_map_of_rings(def->r, def->z, def->num_rings, &def->depths, err);
}

/* Returns the largest slope of all facets; infinite if a facet is upright or faces down. */
static double steepest_facet(const struct cml_mesh *mesh)
{
    double steepest = 0;
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        const double *a = mesh->vertex[mesh->triangle[i][0]], *b = mesh->vertex[mesh->triangle[i][1]],
                     *c = mesh->vertex[mesh->triangle[i][2]];
        double normal[3];
        cml_vec3_area(a, b, c, normal);
        const double up = -normal[2]; /* z points down */
        if (!(up > 0)) return INFINITY;
        steepest = fmax(steepest, hypot(normal[0], normal[1]) / up);
    }
    return steepest;
}

/* Writes the reason for the representation, and adds ", a sheet" if rays walk the mesh's grid of cells. */
static void give_reason(const char *reason, struct cml_surface_def *def)
{
    snprintf(def->reason, sizeof def->reason, "%s%s", reason,
             cml_mesh_surface_is_sheet(def->mesh) ? ", a sheet" : "");
}

/* Makes *def a mesh that queries search. On success the mesh's arrays are taken over. */
static cml_status make_mesh(struct cml_mesh *mesh, double depth, const struct cml_surface_options *options,
                            const char *reason, struct cml_surface_def *def, struct cml_error *err)
{
    def->kind = CML_SURFACE_MESH;
    def->depth = depth;
    def->steepest = steepest_facet(mesh);
    def->lowest = fmin(mesh->lower[2], mesh->z_border);
    def->highest = fmax(mesh->upper[2], mesh->z_border);
    CML_TRY(cml_depth_map_of_mesh(mesh, &def->depths, err));
    CML_TRY(cml_mesh_surface_create(mesh, options->origin[0], options->origin[1], options->search, &def->mesh,
                                    err));
    def->primitives = cml_mesh_surface_primitives(def->mesh);
    give_reason(reason, def);
    return CML_OK;
}

/* Tessellates the boundary's radial heightfield within the budget of triangles. */
static cml_status tessellate(const struct cml_scene *scene, const struct cml_boundary *boundary,
                             const struct cml_surface_options *options, struct cml_mesh *mesh,
                             struct cml_error *err)
{
    const struct cml_tessellation tessellation = cml_choice_tessellation(options);
    struct cml_mesh_budget budget = options->budget;
    budget.file = scene->file;
    budget.line = boundary->line;
    budget.boundary = (int)(boundary - scene->boundaries);
    return cml_tessellate(&boundary->radial, &tessellation, &budget, mesh, err);
}

/* Represents a radial heightfield by a mesh of triangles, and estimates the accuracy of this. */
static cml_status make_tessellated(const struct cml_scene *scene, const struct cml_boundary *boundary,
                                   const struct cml_surface_options *options, struct cml_surface_def *def,
                                   struct cml_error *err)
{
    CML_AT_END(cml_mesh_clear) struct cml_mesh mesh = {0};
    CML_TRY(tessellate(scene, boundary, options, &mesh, err));
    def->expectation = cml_choice_expect_tessellation(options);
    return make_mesh(&mesh, boundary->z, options, "radial heightfield, tessellated", def, err);
}

/* Represents a radial heightfield. In cones that the program chooses, rings on a straight line are merged.
 * Cones that the user asks for keep every ring of the file. */
static cml_status represent_field(const struct cml_scene *scene, const struct cml_boundary *boundary,
                                  const struct cml_surface_options *options, struct cml_surface_def *def,
                                  struct cml_error *err)
{
    const struct cml_radial *field = &boundary->radial;
    const bool forced = options->force == CML_SURFACE_CONE || options->force == CML_SURFACE_MESH;
    if (field->n == 1 || (!forced && cml_radial_is_flat(field))) {
        make_plane(boundary->z - field->h[0], "flat heightfield", def);
        return CML_OK;
    }
    if (options->force == CML_SURFACE_MESH) return make_tessellated(scene, boundary, options, def, err);
    if (options->force == CML_SURFACE_CONE) return make_cones(field, field->n, boundary->z, def, err);
    CML_AT_END(cml_radial_clear) struct cml_radial merged = {0};
    CML_TRY(cml_radial_merge(field, &merged, err));
    return make_cones(&merged, field->n, boundary->z, def, err);
}

/* Refuses to represent a mesh or a tile by cones. */
static cml_status refuse_cones(const struct cml_scene *scene, const struct cml_boundary *boundary,
                               struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT,
                    "%s:%d: --boundaries cone cannot represent a mesh (expected auto or mesh)", scene->file,
                    boundary->line);
}

/* Represents a boundary that is a mesh: by a plane if the mesh is flat and the user forces nothing else,
 * otherwise by a mesh with a search. */
static cml_status represent_mesh(const struct cml_scene *scene, const struct cml_boundary *boundary,
                                 const struct cml_surface_options *options, struct cml_surface_def *def,
                                 struct cml_error *err)
{
    double z;
    if (options->force == CML_SURFACE_CONE) return refuse_cones(scene, boundary, err);
    if (options->force == CML_SURFACE_AUTO && cml_mesh_is_flat(&boundary->mesh, &z)) {
        make_plane(boundary->z + z, "flat mesh", def);
        return CML_OK;
    }
    CML_AT_END(cml_mesh_clear) struct cml_mesh mesh = {0};
    CML_TRY(cml_mesh_copy(&boundary->mesh, &mesh, err));
    char reason[sizeof def->reason] = "mesh";
    const struct cml_heightmap_notes *notes = &boundary->map_notes;
    if (notes->cells > 0)
        snprintf(reason, sizeof reason, "heightmap: %zu of %zu triangles and a skirt", notes->triangles,
                 2 * notes->cells);
    def->expectation = cml_choice_expect_mesh();
    return make_mesh(&mesh, boundary->z, options, reason, def, err);
}

/* Makes the searchable mesh of a repeated heightmap: one period and a margin around it, which queries shift
 * to where the packet is. */
static cml_status make_repeated_mesh(const struct cml_heightmap *tile, struct cml_mesh *mesh,
                                     const struct cml_surface_options *options, struct cml_surface_def *def,
                                     struct cml_error *err)
{
    const struct cml_tile_cells cells = cml_tile_patch_cells(tile);
    const struct cml_mesh_period period = {.n = {tile->nx, tile->ny},
                                           .margin = {-cells.first[0], -cells.first[1]},
                                           .corner = {tile->x0, tile->y0},
                                           .cell = {tile->dx, tile->dy}};
    CML_TRY(cml_depth_map_of_tile(tile, &def->depths, err));
    CML_TRY(cml_mesh_surface_create_tile(mesh, options->origin[0], options->origin[1], options->search,
                                         &period, &def->mesh, err));
    def->primitives = cml_mesh_surface_primitives(def->mesh);
    char reason[96];
    snprintf(reason, sizeof reason, "heightmap repeated every %g x %g cm", cml_tile_period(tile, 0),
             cml_tile_period(tile, 1));
    give_reason(reason, def);
    return CML_OK;
}

/* Represents a boundary that is a tile: by a plane if the tile is flat and the user forces nothing else,
 * otherwise by the mesh of one period. */
static cml_status represent_tile(const struct cml_scene *scene, const struct cml_boundary *boundary,
                                 const struct cml_surface_options *options, struct cml_surface_def *def,
                                 struct cml_error *err)
{
    const struct cml_heightmap *tile = &boundary->tile;
    if (options->force == CML_SURFACE_CONE) return refuse_cones(scene, boundary, err);
    if (options->force == CML_SURFACE_AUTO && cml_tile_is_flat(tile)) {
        make_plane(boundary->z - tile->h[0], "flat heightmap", def);
        return CML_OK;
    }
    CML_AT_END(cml_mesh_clear) struct cml_mesh mesh = {0};
    const struct cml_tile_cells cells = cml_tile_patch_cells(tile);
    CML_TRY(cml_tile_patch(tile, &cells, boundary->tile_normals, &mesh, err));
    def->kind = CML_SURFACE_MESH;
    def->depth = boundary->z;
    def->steepest = steepest_facet(&mesh);
    def->lowest = mesh.lower[2];
    def->highest = mesh.upper[2];
    def->expectation = cml_choice_expect_mesh();
    return make_repeated_mesh(tile, &mesh, options, def, err);
}

/* Represents a boundary for queries: as the kind that --boundaries forces, or as the one that suits it
 * best. */
static cml_status represent(const struct cml_scene *scene, const struct cml_boundary *boundary,
                            const struct cml_surface_options *options, struct cml_surface_def *def,
                            struct cml_error *err)
{
    if (boundary->form == CML_FORM_PLANE)
        make_plane(boundary->z,
                   boundary->line                                             ? "shape ignored"
                   : boundary == scene->boundaries && scene->num_contacts > 0 ? "faces and ports touch it"
                                                                              : "no surface given",
                   def);
    else if (options->force == CML_SURFACE_PLANE)
        make_plane(boundary->z, "surface ignored as asked", def);
    else if (boundary->form == CML_FORM_RADIAL)
        return represent_field(scene, boundary, options, def, err);
    else if (boundary->form == CML_FORM_TILE)
        return represent_tile(scene, boundary, options, def, err);
    else
        return represent_mesh(scene, boundary, options, def, err);
    return CML_OK;
}

/* Returns the surface of `options->shared` that has the same shape as the boundary, or NULL. Planes are not
 * shared, because their depth depends on the boundary's heights. */
static const struct cml_surface_def *shared_surface(const struct cml_boundary *boundary, size_t b,
                                                    const struct cml_surface_options *options)
{
    const struct cml_surface_def *shared = options->shared ? &options->shared->item[b] : NULL;
    return shared && shared->shape && shared->shape == boundary->users ? shared : NULL;
}

/* Makes *def share a surface at another depth. The shape can be shared because its z counts from the
 * boundary's nominal depth. */
static void share(const struct cml_surface_def *shared, double depth, struct cml_surface_def *def)
{
    *def = *shared;
    def->depth = depth;
    def->build_seconds = 0;
    cml_share(def->users);
}

/* Represents a boundary and notes the time and the memory that this takes. */
static cml_status represent_timed(const struct cml_scene *scene, const struct cml_boundary *boundary,
                                  const struct cml_surface_options *options, struct cml_surface_def *def,
                                  struct cml_error *err)
{
    const double begin = cml_now();
    CML_TRY(represent(scene, boundary, options, def, err));
    if (def->kind != CML_SURFACE_PLANE) def->shape = boundary->users;
    CML_TRY(cml_share_begin(&def->users, err));
    def->build_seconds = cml_now() - begin;
    def->bytes = 3 * (double)def->num_rings * sizeof *def->r + 2 * (double)def->depths.cells * sizeof(float);
    if (def->mesh) def->bytes += cml_mesh_surface_bytes(def->mesh);
    return CML_OK;
}

/* True if the scene can share the bodies of `options->shared`: the bodies are the same, and so are the depths
 * of all boundaries. */
static bool shares_bodies(const struct cml_scene *scene, const struct cml_surface_options *options,
                          const struct cml_surface_set *set)
{
    if (!options->shared || scene->num_bodies == 0 || options->shared->bodies.of != scene->bodies)
        return false;
    for (int b = 0; b < set->count; b++)
        if (set->item[b].depth != options->shared->item[b].depth) return false;
    return true;
}

/* Represents the bodies, after the boundaries: each body counts z from the depth of its layer's boundary.
 * Bodies become meshes if --boundaries forces meshes. */
static cml_status represent_bodies(const struct cml_scene *scene, const struct cml_surface_options *options,
                                   struct cml_surface_set *set, struct cml_error *err)
{
    const double tolerance =
        options->force == CML_SURFACE_MESH ? cml_choice_tessellation(options).tolerance : 0;
    if (shares_bodies(scene, options, set)) {
        cml_body_surfaces_share(&options->shared->bodies, &set->bodies);
        return CML_OK;
    }
    CML_FREED double *depths = malloc((size_t)set->count * sizeof *depths);
    if (!depths) return cml_fail_memory(err, set->count * (double)sizeof *depths, "depths");
    for (int b = 0; b < set->count; b++) depths[b] = set->item[b].depth;
    return cml_body_surfaces_create(scene, set->origin.at, depths, tolerance, options->search, &set->bodies,
                                    err);
}

cml_status cml_surfaces_create(const struct cml_scene *scene, const struct cml_surface_options *options,
                               struct cml_surface_set *set, struct cml_error *err)
{
    const size_t count = (size_t)scene->num_layers + 1;
    *set = (struct cml_surface_set){0};
    CML_TRY(cml_surface_origin(scene, &set->origin, err));
    set->count = (int)count;
    set->item = calloc(count, sizeof *set->item);
    if (!set->item) return cml_fail_memory(err, (double)(count * sizeof *set->item), "the boundaries");
    struct cml_surface_options own = *options;
    const double *origin = set->origin.at, *other = own.shared ? own.shared->origin.at : origin;
    if (other[0] != origin[0] || other[1] != origin[1]) own.shared = NULL;
    own.origin = origin;
    options = &own;
    cml_status status = CML_OK;
    for (size_t b = 0; b < count && status == CML_OK; b++) {
        const struct cml_boundary *boundary = &scene->boundaries[b];
        const struct cml_surface_def *shared = shared_surface(boundary, b, options);
        if (shared)
            share(shared, boundary->z, &set->item[b]);
        else
            status = represent_timed(scene, boundary, options, &set->item[b], err);
        set->item[b].rough = boundary->rough;
    }
    if (status == CML_OK) status = represent_bodies(scene, options, set, err);
    if (status != CML_OK) cml_surfaces_free(set);
    return status;
}

void cml_surface_make_outer_plane(const struct cml_boundary *boundary, struct cml_surface_def *def)
{
    *def = (struct cml_surface_def){.kind = CML_SURFACE_PLANE, .rough = boundary->rough};
    make_plane(cml_outer_depth(boundary),
               boundary->form == CML_FORM_MESH   ? "mesh"
               : boundary->form == CML_FORM_TILE ? "heightmap repeated"
                                                 : "radial heightfield",
               def);
}

/* The ring's radius of 1 cm is arbitrary. */
cml_status cml_surface_make_level_rings(const struct cml_boundary *boundary, struct cml_surface_def *def,
                                        struct cml_error *err)
{
    const double height = cml_outer_height(boundary);
    double r[] = {0, 1}, h[] = {height, height};
    const struct cml_radial level = {2, r, h};
    *def = (struct cml_surface_def){.kind = CML_SURFACE_CONE, .rough = boundary->rough};
    return make_cones(&level, level.n, boundary->z, def, err);
}

void cml_surface_clear(struct cml_surface_def *def)
{
    if (cml_share_end(def->users)) {
        free(def->r);
        cml_mesh_surface_free(def->mesh);
        cml_depth_map_clear(&def->depths);
    }
    *def = (struct cml_surface_def){.kind = CML_SURFACE_PLANE};
}

void cml_surfaces_free(struct cml_surface_set *set)
{
    for (int b = 0; set->item && b < set->count; b++) cml_surface_clear(&set->item[b]);
    free(set->item);
    cml_body_surfaces_free(&set->bodies);
    *set = (struct cml_surface_set){0};
}

bool cml_surfaces_are_planes(const struct cml_surface_set *set)
{
    if (set->bodies.count > 0) return false;
    for (int b = 0; b < set->count; b++)
        if (set->item[b].kind != CML_SURFACE_PLANE) return false;
    return true;
}

bool cml_surfaces_are_smooth_planes(const struct cml_surface_set *set)
{
    for (int b = 0; b < set->count; b++)
        if (cml_is_rough(&set->item[b].rough)) return false;
    return cml_surfaces_are_planes(set);
}

/* Makes the mesh of one period of a tile, up to the first samples of the next period. */
static cml_status one_period(const struct cml_heightmap *tile, struct cml_mesh *mesh, struct cml_error *err)
{
    const struct cml_tile_cells cells = {{0, 0}, {tile->nx, tile->ny}};
    return cml_tile_sheet(tile, &cells, CML_NORMALS_FACET, mesh, err);
}

/* A heightfield of equal heights has a mesh, too; a heightfield of one sample and a plane have none. */
cml_status cml_boundary_mesh(const struct cml_scene *scene, int b, const struct cml_surface_options *options,
                             struct cml_mesh *mesh, struct cml_error *err)
{
    const struct cml_boundary *boundary = &scene->boundaries[b];
    if (boundary->form == CML_FORM_MESH) return cml_mesh_copy(&boundary->mesh, mesh, err);
    if (boundary->form == CML_FORM_TILE) return one_period(&boundary->tile, mesh, err);
    if (boundary->form == CML_FORM_RADIAL && boundary->radial.n > 1)
        return tessellate(scene, boundary, options, mesh, err);
    *mesh = (struct cml_mesh){0};
    return CML_OK;
}
