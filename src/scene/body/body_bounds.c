/* Compares bodies with the boundaries of their layer. SPDX-License-Identifier: MIT */
#include "geometry/vec3.h"
#include "scene/body/body_place.h"
#include "scene/body/body_shape.h"
#include "scene/overlap_radial.h"
#include "scene/overlap_sheet.h"

#include <float.h>
#include <math.h>

#define SIDES 512 /* sides of the prism around a cylinder */

/* The comparison of one body with one boundary. */
struct encounter {
    const struct cml_scene *scene;
    const struct cml_boundary *boundary;
    struct cml_sheet sheet; /* the boundary's sheet, if it is a mesh */
    double top, bottom;     /* least and greatest z of the boundary, cm */
    int number;             /* number of the boundary */
    bool below;             /* true if the body must lie below the boundary */
    const struct cml_scene_body *body;
    double lower[3], upper[3]; /* the body's bounding box */
    double at[3];              /* place of a failure, scene coordinates, cm */
};

/* Refuses a body that meets a boundary. what: "meets", "lies above" and the like. */
static cml_status fail_encounter(const struct encounter *e, const char *what, struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT,
                    "%s:%d: body %d %s boundary %d at (%g %g %g) cm (expected it inside its layer)",
                    e->scene->file, e->body->line, (int)(e->body - e->scene->bodies) + 1, what, e->number,
                    e->at[0], e->at[1], e->at[2]);
}

/* Largest rounding error of a gap, as a share of the size of the coordinates; convex.c uses the same share
 * for gaps between bodies. */
static const double err_share = 64 * DBL_EPSILON;

/* Refuses a body whose box does not lie on its own side of a plane boundary. The reported place is the
 * middle of the box, moved to the plane. */
static cml_status compare_with_plane(struct encounter *e, double z, struct cml_error *err)
{
    const double *lower = e->lower, *upper = e->upper;
    const double err_depth = err_share * (fabs(z) + fabs(lower[2]) + fabs(upper[2]));
    if (e->below ? lower[2] > z + err_depth : upper[2] < z - err_depth) return CML_OK;
    for (int k = 0; k < 2; k++) e->at[k] = 0.5 * (lower[k] + upper[k]);
    e->at[2] = z;
    return fail_encounter(e,
                          e->below       ? upper[2] < z ? "lies above" : "meets"
                          : lower[2] > z ? "lies below"
                                         : "meets",
                          err);
}

/* Returns the distance from a point (r, z), in a half-plane through the axis, to the segment from (r0, z0) to
 * (r1, z1). */
static double distance_to_segment(double r, double z, double r0, double z0, double r1, double z1)
{
    const double dr = r1 - r0, dz = z1 - z0;
    const double s = fmax(0, fmin(1, ((r - r0) * dr + (z - z0) * dz) / (dr * dr + dz * dz)));
    return hypot(r - r0 - s * dr, z - z0 - s * dz);
}

/* Compares a sphere with a radial heightfield. The closest place of a surface of revolution lies in the
 * half-plane through the axis and the sphere's centre. Samples beyond the sphere's reach are skipped. */
static cml_status compare_sphere_with_field(struct encounter *e, struct cml_error *err)
{
    const struct cml_radial *field = &e->boundary->radial;
    const double *c = e->body->centre, r = hypot(c[0], c[1]), z_b = e->boundary->z;
    const int last = field->n - 1;
    const double surface = z_b - cml_radial_height(field, r);
    const double err_distance = err_share * (fabs(c[2]) + r + fabs(z_b) + e->body->radius);
    const double reach = e->body->radius + 2 * err_distance;
    double nearest = INFINITY;
    const int from = cml_radial_sample_from(field, r - reach);
    for (int i = from > 0 ? from - 1 : 0; i < last && field->r[i] <= r + reach; i++)
        nearest = fmin(nearest, distance_to_segment(r, c[2], field->r[i], z_b - field->h[i], field->r[i + 1],
                                                    z_b - field->h[i + 1]));
    const double z_out = z_b - field->h[last];
    nearest = fmin(nearest, hypot(fmax(0, field->r[last] - r), c[2] - z_out));
    const bool beyond = !(e->below ? c[2] > surface : c[2] < surface),
               apart = nearest > e->body->radius + err_distance;
    if (apart && !beyond) return CML_OK;
    e->at[0] = c[0];
    e->at[1] = c[1];
    e->at[2] = surface;
    return fail_encounter(e, apart ? "lies beyond" : "meets", err);
}

/* Refuses a body that is a mesh if it meets a radial heightfield or lies beyond it: the smallest gap tells
 * both. */
static cml_status compare_mesh_with_field(struct encounter *e, const struct cml_mesh *mesh,
                                          struct cml_error *err)
{
    const struct cml_radial_surface field = {&e->boundary->radial, e->boundary->z};
    struct cml_closest closest = {.gap = INFINITY};
    cml_radial_against_mesh(&field, mesh, NULL, 0, !e->below, &closest);
    if (closest.gap > closest.err_gap) return CML_OK;
    cml_vec3_copy(closest.at, e->at);
    return fail_encounter(e, "meets", err);
}

/* Compares a sphere with a mesh boundary. A sphere that reaches the depth of the outer plane must do so
 * inside the border, and must not meet the border's edges. */
static cml_status compare_sphere_with_sheet(struct encounter *e, struct cml_error *err)
{
    const struct cml_convex convex = cml_body_convex(e->body);
    const struct cml_sheet *sheet = &e->sheet;
    const double *c = e->body->centre;
    const double margin = 4 * err_share * (fabs(c[0]) + fabs(c[1]) + fabs(c[2]) + e->body->radius);
    double lower[3], upper[3];
    for (int k = 0; k < 3; k++) {
        lower[k] = e->lower[k] - margin;
        upper[k] = e->upper[k] + margin;
    }
    cml_vec3_copy(c, e->at);
    if (cml_compare_with_facets(sheet, &convex, lower, upper, e->at) > 0)
        return fail_encounter(e, "meets", err);
    e->at[2] = sheet->z_plane;
    if (fabs(c[2] - sheet->z_plane) <= e->body->radius &&
        !cml_footprint_contains(sheet->footprint, c[0], c[1]))
        return fail_encounter(e, "meets", err);
    if (cml_sheet_is_below(sheet, c) != e->below) return fail_encounter(e, "lies beyond", err);
    return CML_OK;
}

/* True if a part of the body's mesh lies on the wrong side of the boundary, which the body does not meet.
 * Each part then lies wholly on one side. Writes a corner of this part to e->at, for the message. */
static bool lies_beyond(struct encounter *e, const struct cml_sheet *body)
{
    for (size_t k = 0; k < body->mesh->num_parts; k++) {
        const double *corner = cml_sheet_part_start(body, k);
        if (cml_sheet_is_below(&e->sheet, corner) == e->below) continue;
        cml_vec3_copy(corner, e->at);
        return true;
    }
    return false;
}

/* Refuses a body that is a mesh if it meets a boundary that is a mesh, too, or lies beyond the boundary. */
static cml_status compare_mesh_with_sheet(struct encounter *e, const struct cml_mesh *mesh,
                                          struct cml_error *err)
{
    CML_AT_END(cml_sheet_clear) struct cml_sheet body = {0};
    struct cml_sheet_overlap overlap;
    CML_TRY(cml_sheet_create(mesh, 0, &body, err));
    cml_sheet_contact(&body, &e->sheet, &overlap);
    if (overlap.contact == CML_APART)
        return lies_beyond(e, &body) ? fail_encounter(e, "lies beyond", err) : CML_OK;
    cml_vec3_copy(overlap.at, e->at);
    return fail_encounter(e, "meets", err);
}

/* Refuses a body that meets a boundary that is not a plane; the body is a mesh, or a cylinder taken as a
 * prism around it. */
static cml_status compare_mesh(struct encounter *e, struct cml_error *err)
{
    CML_AT_END(cml_mesh_clear) struct cml_mesh mesh = {0};
    CML_TRY(cml_body_mesh(e->body, SIDES, true, &mesh, err));
    return e->boundary->form == CML_FORM_MESH ? compare_mesh_with_sheet(e, &mesh, err)
                                              : compare_mesh_with_field(e, &mesh, err);
}

/* Refuses a body that reaches the depths of a repeated heightmap. A tile has no triangles to compare the
 * body with, so its whole range of depths counts. */
static cml_status fail_at_tile(const struct encounter *e, struct cml_error *err)
{
    return cml_fail(
        err, CML_E_INPUT,
        "%s:%d: body %d lies at depths of %g..%g cm and boundary %d, a tile, at %g..%g cm (expected "
        "a body wholly %s the tile's depths)",
        e->scene->file, e->body->line, (int)(e->body - e->scene->bodies) + 1, e->lower[2], e->upper[2],
        e->number, e->top, e->bottom, e->below ? "below" : "above");
}

/* Compares a body with a boundary. Only bodies whose box reaches the boundary's depths need more than the
 * box. */
static cml_status compare(struct encounter *e, struct cml_error *err)
{
    const enum cml_boundary_form form = e->boundary->form;
    cml_body_box(e->body, e->lower, e->upper);
    if (form != CML_FORM_MESH && e->top == e->bottom) return compare_with_plane(e, e->top, err);
    if (e->below ? e->lower[2] > e->bottom : e->upper[2] < e->top) return CML_OK;
    if (form == CML_FORM_TILE) return fail_at_tile(e, err);
    if (e->body->form != CML_BODY_SPHERE) return compare_mesh(e, err);
    return form == CML_FORM_MESH ? compare_sphere_with_sheet(e, err) : compare_sphere_with_field(e, err);
}

/* Prepares a boundary for comparison with bodies: the depths between which it lies and, if it is a mesh, its
 * search structure. */
static cml_status prepare(struct encounter *e, struct cml_error *err)
{
    const struct cml_boundary *boundary = e->boundary;
    const struct cml_radial *radial = &boundary->radial;
    const struct cml_heightmap *tile = &boundary->tile;
    e->top = e->bottom = boundary->z;
    if (boundary->form == CML_FORM_RADIAL)
        cml_depth_range(radial->h, (size_t)radial->n, boundary->z, &e->top, &e->bottom);
    if (boundary->form == CML_FORM_TILE)
        cml_depth_range(tile->h, (size_t)tile->nx * (size_t)tile->ny, boundary->z, &e->top, &e->bottom);
    if (boundary->form != CML_FORM_MESH) return CML_OK;
    CML_TRY(cml_sheet_create(&boundary->mesh, boundary->z, &e->sheet, err));
    e->top = e->sheet.top;
    e->bottom = e->sheet.bottom;
    return CML_OK;
}

/* Refuses bodies that lie directly in a layer and meet boundary `number`, the one above or below it. */
static cml_status check_boundary(const struct cml_scene *scene, int layer, int number, struct cml_error *err)
{
    const struct cml_body_range bodies = cml_layer_bodies(scene, layer);
    struct encounter e = {
        .scene = scene, .boundary = &scene->boundaries[number], .number = number, .below = number < layer};
    cml_status status = bodies.first < bodies.end ? prepare(&e, err) : CML_OK;
    for (int k = bodies.first; status == CML_OK && k < bodies.end; k++) {
        e.body = &scene->bodies[k];
        if (e.body->host == layer) status = compare(&e, err);
    }
    cml_sheet_clear(&e.sheet);
    return status;
}

cml_status cml_scene_check_bodies(const struct cml_scene *scene, struct cml_error *err)
{
    for (int layer = 1; layer <= scene->num_layers; layer++) {
        CML_TRY(check_boundary(scene, layer, layer - 1, err));
        CML_TRY(check_boundary(scene, layer, layer, err));
    }
    return CML_OK;
}

cml_status cml_scene_check_shapes(const struct cml_scene *scene, struct cml_error *err)
{
    CML_TRY(cml_scene_check_steepness(scene, err));
    CML_TRY(cml_scene_check_overlap(scene, err));
    return cml_scene_check_bodies(scene, err);
}
