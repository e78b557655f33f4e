/* Bodies against the boundaries of their layer. SPDX-License-Identifier: MIT */
#include "geometry/vec3.h"
#include "scene/body/body_place.h"
#include "scene/body/body_shape.h"
#include "scene/overlap_radial.h"
#include "scene/overlap_sheet.h"

#include <float.h>
#include <math.h>

#define SIDES 512 /* of the prism around a cylinder */

/* One body beside one boundary. */
struct encounter {
    const struct cml_scene *scene;
    const struct cml_scene_body *body;
    const struct cml_boundary *boundary;
    int number;   /* of the boundary */
    bool below;   /* the body must lie below it */
    double at[3]; /* where it does not */
};

static cml_status fail_encounter(const struct encounter *e, const char *what, struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "%s:%d: body %d %s boundary %d at (%g %g %g) cm", e->scene->file,
                    e->body->line, (int)(e->body - e->scene->bodies) + 1, what, e->number, e->at[0], e->at[1],
                    e->at[2]);
}

/* Of the size of the coordinates, as of bodies among each other (convex.c). */
static const double err_share = 64 * DBL_EPSILON;

/* The place is the body's closest to the plane, or farthest beyond. */
static cml_status compare_with_plane(struct encounter *e, double z, struct cml_error *err)
{
    double lower[3], upper[3];
    cml_body_box(e->body, lower, upper);
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

/* From a point (r, z) of a half-plane through the axis to one of the segments of the outline. */
static double distance_to_segment(double r, double z, double r0, double z0, double r1, double z1)
{
    const double dr = r1 - r0, dz = z1 - z0;
    const double s = fmax(0, fmin(1, ((r - r0) * dr + (z - z0) * dz) / (dr * dr + dz * dz)));
    return hypot(r - r0 - s * dr, z - z0 - s * dz);
}

/* The closest place of a surface of revolution lies in the half-plane of the sphere's centre. */
static cml_status compare_sphere_with_field(struct encounter *e, struct cml_error *err)
{
    const struct cml_radial *field = &e->boundary->radial;
    const double *c = e->body->centre, r = hypot(c[0], c[1]), z_b = e->boundary->z;
    const int last = field->n - 1;
    const double surface = z_b - cml_radial_height(field, r);
    double nearest = INFINITY;
    for (int i = 0; i < last; i++)
        nearest = fmin(nearest, distance_to_segment(r, c[2], field->r[i], z_b - field->h[i], field->r[i + 1],
                                                    z_b - field->h[i + 1]));
    const double z_out = z_b - field->h[last];
    nearest = fmin(nearest, hypot(fmax(0, field->r[last] - r), c[2] - z_out));
    const double err_distance = err_share * (fabs(c[2]) + r + fabs(z_b) + e->body->radius);
    const bool beyond = !(e->below ? c[2] > surface : c[2] < surface),
               apart = nearest > e->body->radius + err_distance;
    if (apart && !beyond) return CML_OK;
    e->at[0] = c[0];
    e->at[1] = c[1];
    e->at[2] = surface;
    return fail_encounter(e, apart ? "lies beyond" : "meets", err);
}

/* Gap and side at once (overlap_radial.h). */
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

/* A sphere that crosses the outer plane's depth must do so inside the border, whose edges it does not meet.
 */
static cml_status compare_sphere_with_sheet(struct encounter *e, const struct cml_sheet *sheet,
                                            struct cml_error *err)
{
    const struct cml_convex convex = cml_body_convex(e->body);
    const struct cml_mesh *mesh = sheet->mesh;
    const double *c = e->body->centre;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        struct cml_convex triangle = {.form = CML_CONVEX_TRIANGLE};
        for (int k = 0; k < 3; k++) triangle.corner[k] = sheet->vertex[mesh->triangle[t][k]];
        if (cml_convex_compare(&triangle, &convex, e->at) != CML_CONVEX_APART)
            return fail_encounter(e, "meets", err);
    }
    cml_vec3_copy(c, e->at);
    e->at[2] = sheet->z_plane;
    if (fabs(c[2] - sheet->z_plane) <= e->body->radius &&
        !cml_footprint_contains(sheet->footprint, c[0], c[1]))
        return fail_encounter(e, "meets", err);
    if (cml_sheet_is_below(sheet, c) != e->below) return fail_encounter(e, "lies beyond", err);
    return CML_OK;
}

static cml_status compare_mesh_with_sheet(struct encounter *e, const struct cml_mesh *mesh,
                                          const struct cml_sheet *sheet, struct cml_error *err)
{
    struct cml_sheet body;
    struct cml_sheet_overlap overlap;
    CML_TRY(cml_sheet_create(mesh, 0, &body, err));
    cml_sheet_contact(&body, sheet, &overlap);
    const bool below = cml_sheet_is_below(sheet, body.vertex[0]);
    cml_vec3_copy(overlap.contact == CML_APART ? body.vertex[0] : overlap.at, e->at);
    cml_sheet_clear(&body);
    if (overlap.contact != CML_APART) return fail_encounter(e, "meets", err);
    return below == e->below ? CML_OK : fail_encounter(e, "lies beyond", err);
}

/* Meshes, and cylinders as prisms, against what is no plane. */
static cml_status compare_mesh(struct encounter *e, const struct cml_sheet *sheet, struct cml_error *err)
{
    struct cml_mesh mesh;
    CML_TRY(cml_body_mesh(e->body, SIDES, true, &mesh, err));
    const cml_status status =
        sheet ? compare_mesh_with_sheet(e, &mesh, sheet, err) : compare_mesh_with_field(e, &mesh, err);
    cml_mesh_clear(&mesh);
    return status;
}

/* Where the body's box ends before the boundary begins nothing else is looked at. */
static bool is_clear(const struct encounter *e, double top, double bottom)
{
    double lower[3], upper[3];
    cml_body_box(e->body, lower, upper);
    return e->below ? lower[2] > bottom : upper[2] < top;
}

static cml_status compare_with_field(struct encounter *e, struct cml_error *err)
{
    const struct cml_radial *field = &e->boundary->radial;
    double top = INFINITY, bottom = -INFINITY;
    for (int i = 0; i < field->n; i++) {
        top = fmin(top, e->boundary->z - field->h[i]);
        bottom = fmax(bottom, e->boundary->z - field->h[i]);
    }
    if (top == bottom) return compare_with_plane(e, top, err);
    if (is_clear(e, top, bottom)) return CML_OK;
    return e->body->form == CML_BODY_SPHERE ? compare_sphere_with_field(e, err) : compare_mesh(e, NULL, err);
}

/* All bodies that lie right in a layer, against one of its boundaries. */
static cml_status check_boundary(const struct cml_scene *scene, int layer, int number, struct cml_error *err)
{
    const struct cml_boundary *boundary = &scene->boundaries[number];
    struct cml_sheet sheet = {0};
    if (boundary->form == CML_FORM_MESH) CML_TRY(cml_sheet_create(&boundary->mesh, boundary->z, &sheet, err));
    cml_status status = CML_OK;
    for (int k = 0; status == CML_OK && k < scene->num_bodies; k++) {
        struct encounter e = {scene, &scene->bodies[k], boundary, number, number < layer, {0}};
        if (e.body->host != layer) continue;
        if (boundary->form == CML_FORM_PLANE)
            status = compare_with_plane(&e, boundary->z, err);
        else if (boundary->form == CML_FORM_RADIAL)
            status = compare_with_field(&e, err);
        else if (!is_clear(&e, sheet.top, sheet.bottom))
            status = e.body->form == CML_BODY_SPHERE ? compare_sphere_with_sheet(&e, &sheet, err)
                                                     : compare_mesh(&e, &sheet, err);
    }
    cml_sheet_clear(&sheet);
    return status;
}

cml_status cml_scene_check_bodies(const struct cml_scene *scene, struct cml_error *err)
{
    for (int layer = 1; layer <= scene->num_layers; layer++) {
        if (!cml_medium_has_bodies(scene, layer)) continue;
        CML_TRY(check_boundary(scene, layer, layer - 1, err));
        CML_TRY(check_boundary(scene, layer, layer, err));
    }
    return CML_OK;
}

cml_status cml_scene_check_shapes(const struct cml_scene *scene, struct cml_error *err)
{
    CML_TRY(cml_scene_check_overlap(scene, err));
    return cml_scene_check_bodies(scene, err);
}
