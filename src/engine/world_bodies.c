/* Bodies as the kernels read them: media, surfaces, shapes, tree and bounds, made from a scene and its
 * surfaces.
 * SPDX-License-Identifier: MIT */
#include "engine/world_parts.h"

#include "scene/body/body_shape.h"

#include <math.h>
#include <stdlib.h>

/* Share of their coordinates by which boxes are enlarged: more than rounding moves a packet, its path or a
 * box. */
static const double err_box_share = 16 * (double)CML_EPSILON;

/* Allocates the arrays of bodies that kernels read: bodies, nodes of the search tree, and grids with their
 * cells. */
static cml_status allocate_bodies(const struct cml_body_surfaces *surfaces, struct cml_owned_world *to,
                                  struct cml_error *err)
{
    to->num_body_nodes = (size_t)surfaces->tree.count;
    to->num_body_grids = (size_t)surfaces->grids.count;
    to->num_body_cells = surfaces->grids.num_cells;
    to->bodies = cml_arrays_add(&to->arrays, (size_t)surfaces->count, sizeof *to->bodies);
    to->body_nodes = cml_arrays_add(&to->arrays, to->num_body_nodes, sizeof *to->body_nodes);
    to->body_grids = cml_arrays_add(&to->arrays, to->num_body_grids, sizeof *to->body_grids);
    to->body_cells = cml_arrays_add(&to->arrays, to->num_body_cells, sizeof *to->body_cells);
    return cml_arrays_check(&to->arrays, "the bodies", err);
}

/* Fills the medium of body k. It has the frame of its layer, so depths and bins do not change at the body's
 * surface. */
static void copy_medium(const struct cml_scene *scene, int k, struct cml_owned_world *to)
{
    const int m = cml_body_medium(scene, k);
    const struct cml_medium *layer = &to->media[scene->bodies[k].layer];
    struct cml_medium *medium = &to->media[m];
    cml_copy_optics(&scene->media[m], medium);
    medium->span = 0;
    medium->depth = layer->depth;
    medium->bins = layer->bins;
}

/* Fills surface L + 1 + k of body k. Above it lies the body's host, below it the body's own medium, L + 2
 * + k. The slope is set to infinity, so that paths are not bounded by it as at boundaries of layers; the
 * grids of bodies tell if a path can meet the body. */
static void copy_body(const struct cml_scene *scene, const double origin[2],
                      const struct cml_body_surface *from, int k, struct cml_owned_world *to)
{
    const struct cml_scene_body *body = &scene->bodies[k];
    const int boundary = scene->num_layers + 1 + k;
    struct cml_surface *surface = &to->surfaces[boundary];
    surface->kind = (int)from->kind;
    surface->above = body->host;
    surface->lowest = (real)from->lower[2];
    surface->highest = (real)from->upper[2];
    surface->steepest = CML_INFINITY;
    to->meshes[boundary] = from->mesh;
    if (from->kind == CML_SURFACE_MESH) return;
    const struct cml_convex convex = cml_body_convex(body);
    const double *c = convex.centre, *axis = convex.axis;
    to->bodies[k].centre = cml_vec_of(c[0] - origin[0], c[1] - origin[1], c[2] - from->depth);
    to->bodies[k].axis = cml_vec_of(axis[0], axis[1], axis[2]);
    to->bodies[k].radius = (real)convex.radius;
    to->bodies[k].length = (real)convex.length;
}

/* Copies the search tree of bodies into the form that kernels read. Boxes are enlarged by more than rounding
 * to the kernels' precision, so that no body reaches out of its box. */
static void copy_tree(const struct cml_scene *scene, const double at[2], const struct cml_body_tree *tree,
                      struct cml_owned_world *to)
{
    const double origin[3] = {at[0], at[1], 0};
    for (int i = 0; i < tree->count; i++) {
        const struct cml_body_tree_node *from = &tree->node[i];
        double lower[3], upper[3];
        for (int k = 0; k < 3; k++) {
            lower[k] = from->lower[k] - origin[k];
            upper[k] = from->upper[k] - origin[k];
            const double more = err_box_share * (fabs(lower[k]) + fabs(upper[k]) + upper[k] - lower[k]);
            lower[k] -= more;
            upper[k] += more;
        }
        to->body_nodes[i].lower = cml_vec_of(lower[0], lower[1], lower[2]);
        to->body_nodes[i].upper = cml_vec_of(upper[0], upper[1], upper[2]);
        to->body_nodes[i].skip = from->skip;
        to->body_nodes[i].body = from->body;
    }
    for (int m = 0; m < scene->num_layers + 2 + scene->num_bodies; m++) {
        to->media[m].first_node = tree->first[m];
        to->media[m].end_node = tree->first[m + 1];
    }
}

/* Copies the grids over bodies into the form that kernels read, relative to `origin`. A cell refers to a
 * body by the number of the body's medium, -1 for none. */
static void copy_grids(const struct cml_scene *scene, const double origin[2],
                       const struct cml_body_grids *grids, struct cml_owned_world *to)
{
    for (int m = 0; m < scene->num_layers + 2 + scene->num_bodies; m++)
        to->media[m].body_grid = grids->of_medium[m];
    for (int i = 0; i < grids->count; i++) {
        const struct cml_body_cells *from = &grids->item[i];
        struct cml_body_grid *grid = &to->body_grids[i];
        grid->nx = from->n[0];
        grid->ny = from->n[1];
        grid->nz = from->n[2];
        grid->first = (int)from->first;
        grid->corner = cml_vec_of(from->corner[0] - origin[0], from->corner[1] - origin[1], from->corner[2]);
        grid->cell = (real)from->cell;
        grid->per_cell = (real)(1 / from->cell);
    }
    for (size_t i = 0; i < to->num_body_cells; i++) {
        const struct cml_body_ball *from = &grids->ball[i];
        to->body_cells[i] =
            (struct cml_body_cell){(real)from->radius,
                                   from->body < 0 ? -1 : cml_body_medium(scene, from->body),
                                   cml_vec_of(from->normal[0], from->normal[1], from->normal[2]),
                                   (real)from->lower,
                                   (real)from->upper,
                                   (real)from->steepest};
    }
}

cml_status cml_copy_bodies(const struct cml_scene *scene, const struct cml_surface_set *set,
                           struct cml_owned_world *to, struct cml_error *err)
{
    const struct cml_body_surfaces *surfaces = &set->bodies;
    const double *origin = set->origin.at;
    if (surfaces->count == 0) return CML_OK;
    CML_TRY(allocate_bodies(surfaces, to, err));
    for (int k = 0; k < surfaces->count; k++) {
        copy_medium(scene, k, to);
        copy_body(scene, origin, &surfaces->item[k], k, to);
    }
    copy_tree(scene, origin, &surfaces->tree, to);
    copy_grids(scene, origin, &surfaces->grids, to);
    to->world.bodies = to->bodies;
    to->world.body_nodes = to->body_nodes;
    to->world.body_grids = to->body_grids;
    to->world.body_cells = to->body_cells;
    return CML_OK;
}
