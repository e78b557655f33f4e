/* What bodies have absorbed, received and sent, as fields: all bodies along one axis, and all their facets
 * along another, whose `body_of_facet` says whose each is; and how bodies are drawn. SPDX-License-Identifier:
 * MIT */
#include "geometry/vec3.h"
#include "output/report_parts.h"
#include "scene/body/body_shape.h"
#include "surface/surface_facets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- where values come from ---- */

/* The body of a facet among those of all. */
static int body_of(const struct cml_report *report, size_t facet)
{
    const struct cml_body_surfaces *bodies = &report->surfaces->bodies;
    int first = 0, last = bodies->count - 1;
    while (first < last) {
        const int middle = last - (last - first) / 2;
        if (bodies->item[middle].first <= facet)
            first = middle;
        else
            last = middle - 1;
    }
    return first;
}

static double area_of(const struct cml_report *report, size_t facet)
{
    const int k = body_of(report, facet);
    const struct cml_body_surface *body = &report->surfaces->bodies.item[k];
    return cml_body_facet_area(body, &report->scene->bodies[k], facet - body->first);
}

static void numbers(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = begin; i < begin + count; i++)
        *out++ = 1 + (source->face ? source->face[i].body : body_of(source->report, i));
}

static void areas(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = begin; i < begin + count; i++) *out++ = area_of(source->report, i);
}

/* `cells` begins at the score in question of the first facet. */
static struct cml_field_cells at_facet(const struct cml_field_source *source, size_t i)
{
    return (struct cml_field_cells){i * CML_FACET_SCORES, 1, area_of(source->report, i)};
}

/* What the facet has received, by the area of the faces that stand for it. */
static struct cml_field_cells at_face(const struct cml_field_source *source, size_t i)
{
    const struct cml_body_face *face = &source->face[i];
    return (struct cml_field_cells){face->facet * CML_FACET_SCORES, 1, face->area};
}

/* ---- fields ---- */

/* The scores of the first facet of the first body: they follow those of all boundaries. */
static const cml_u128 *first_scores(const struct cml_report *report)
{
    size_t facets = 0;
    for (int b = 0; b < report->surfaces->count; b++)
        facets += cml_surface_facets(&report->surfaces->item[b], &report->scene->map);
    return report->sums->facets + facets * CML_FACET_SCORES;
}

/* Fields of what facets have received and sent, or, without the word body in their names, of faces that stand
 * for them. */
static void add_scores(struct cml_field_list *c, const struct cml_body_face *face)
{
    static const enum cml_facet_score scores[] = {CML_FACET_IRRADIANCE_ABOVE, CML_FACET_IRRADIANCE_BELOW,
                                                  CML_FACET_EXITANCE_ABOVE, CML_FACET_EXITANCE_BELOW};
    for (int i = 0; i < (int)(sizeof scores / sizeof *scores); i++) {
        const enum cml_quantity quantity = (enum cml_quantity)(CML_QUANTITY_body_irradiance_outside + i);
        struct cml_field_source *source =
            cml_add_sums(c, quantity, face ? at_face : at_facet, first_scores(c->report) + scores[i]);
        struct cml_field *field = cml_last_field(c);
        source->face = face;
        source->once = cml_facet_once(&c->report->sums->grid);
        if (face)
            snprintf(field->name, sizeof field->name, "%s", cml_quantities[quantity].name + strlen("body_"));
        if (source->once.step) cml_add_error_field(c);
    }
}

static void set_facets(struct cml_field_list *c, enum cml_axis_kind kind, size_t count)
{
    c->axis[CML_AXIS_body_facet] = cml_quantity_axis(kind, count, 0, 1);
}

void cml_add_body_face_fields(struct cml_field_list *c, const struct cml_body_faces *drawn)
{
    set_facets(c, CML_AXIS_face, drawn->faces.num_faces);
    cml_add_field(c, CML_QUANTITY_body_of_facet, numbers)->face = drawn->face;
    snprintf(cml_last_field(c)->name, sizeof cml_last_field(c)->name, "body");
    add_scores(c, drawn->face);
}

void cml_add_body_fields(struct cml_field_list *c)
{
    const struct cml_body_surfaces *bodies = &c->report->surfaces->bodies;
    if (c->report->scene->num_bodies == 0) return;
    const struct cml_body_surface *last = &bodies->item[bodies->count - 1];
    set_facets(c, CML_AXIS_body_facet, last->first + last->primitives);
    if (!c->report->sums->facets) return;
    cml_add_field(c, CML_QUANTITY_body_of_facet, numbers);
    cml_add_field(c, CML_QUANTITY_body_area, areas);
    add_scores(c, NULL);
}

enum { SIDES = CML_FACET_EXITANCE_BELOW + 1 };

/* One of a body's fluxes, over all its facets. */
static void set_flux(const struct cml_report *report, const struct cml_body_surface *of, int side, size_t at,
                     struct cml_outcome *o)
{
    const cml_u128 *scores = first_scores(report) + of->first * CML_FACET_SCORES + side;
    const struct cml_result *sums = report->sums;
    const size_t step = sums->grid.facet_step, groups = cml_groups_of(step);
    cml_u128 group[CML_NUM_GROUPS] = {0};
    for (size_t g = 0; g < groups; g++)
        for (uint64_t i = 0; i < of->primitives; i++) group[g] += scores[g * step + i * CML_FACET_SCORES];
    o->value[CML_QUANTITY_flux_body][at] =
        cml_result_cell_sum(group, (int)groups, 1) * CML_WEIGHT_UNIT / (double)sums->photons;
    if (step) o->error[CML_QUANTITY_flux_body][at] = cml_result_cell_error(sums, group, 1);
}

cml_status cml_report_body_fluxes(const struct cml_report *report, struct cml_outcome *o,
                                  struct cml_error *err)
{
    const struct cml_body_surfaces *bodies = &report->surfaces->bodies;
    if (!report->sums->facets || bodies->count == 0) return CML_OK;
    const size_t step = report->sums->grid.facet_step;
    CML_TRY(cml_outcome_add(o, CML_QUANTITY_flux_body, false, err));
    if (step) CML_TRY(cml_outcome_add(o, CML_QUANTITY_flux_body, true, err));
    for (int at = 0; at < bodies->count * SIDES; at++)
        set_flux(report, &bodies->item[at / SIDES], at % SIDES, (size_t)at, o);
    return CML_OK;
}

/* ---- how bodies are drawn: all of them as triangles in one file ---- */

/* So many that a sphere looks like one, fewer where there are very many bodies. */
static int segments_of(enum cml_body_form form, int bodies)
{
    const bool many = bodies > 100;
    return form == CML_BODY_SPHERE ? (many ? 3 : 12) : (many ? 16 : 64);
}

/* The mesh of body k in scene coordinates; the caller clears it. */
static cml_status mesh_of(const struct cml_report *report, int k, struct cml_mesh *mesh,
                          struct cml_error *err)
{
    const struct cml_scene_body *body = &report->scene->bodies[k];
    const struct cml_body_surface *surface = &report->surfaces->bodies.item[k];
    double middle[3];
    if (!surface->mesh)
        return cml_body_mesh(body, segments_of(body->form, report->scene->num_bodies), false, mesh, err);
    CML_TRY(cml_mesh_copy(cml_mesh_surface_mesh(surface->mesh, middle), mesh, err));
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int axis = 0; axis < 3; axis++)
            mesh->vertex[i][axis] += middle[axis] + (axis == 2 ? surface->depth : 0);
    return CML_OK;
}

/* The part of a cylinder that a triangle of its mesh stands for: 0 the side, 1 the first end, 2 the other. */
static size_t part_of_cylinder(const struct cml_scene_body *body, const struct cml_mesh *mesh,
                               size_t triangle)
{
    const struct cml_convex cylinder = cml_body_convex(body);
    const uint32_t *v = mesh->triangle[triangle];
    double normal[3], from[3];
    cml_vec3_area(mesh->vertex[v[0]], mesh->vertex[v[1]], mesh->vertex[v[2]], normal);
    cml_vec3_subtract(mesh->vertex[v[0]], cylinder.centre, from);
    if (fabs(cml_vec3_dot(normal, cylinder.axis)) < 0.5 * cml_vec3_length(normal)) return 0;
    return cml_vec3_dot(from, cylinder.axis) < 0.5 * cylinder.length ? 1 : 2;
}

static size_t facet_of(const struct cml_report *report, int k, const struct cml_mesh *mesh, size_t triangle)
{
    if (report->surfaces->bodies.item[k].mesh) return triangle;
    const struct cml_scene_body *body = &report->scene->bodies[k];
    return body->form == CML_BODY_SPHERE ? 0 : part_of_cylinder(body, mesh, triangle);
}

static cml_status grow(struct cml_body_faces *drawn, size_t points, size_t faces, struct cml_error *err)
{
    struct cml_faces *to = &drawn->faces;
    void *point = realloc(to->point, (to->num_points + points) * sizeof *to->point);
    if (point) to->point = point;
    void *corner = realloc(to->corner, 3 * (to->num_faces + faces) * sizeof *to->corner);
    if (corner) to->corner = corner;
    void *face = realloc(drawn->face, (to->num_faces + faces) * sizeof *drawn->face);
    if (face) drawn->face = face;
    if (point && corner && face) return CML_OK;
    return cml_fail_memory(err, (double)((to->num_faces + faces) * sizeof *drawn->face), "faces of bodies");
}

static cml_status add_body(const struct cml_report *report, int k, const struct cml_mesh *mesh,
                           struct cml_body_faces *drawn, struct cml_error *err)
{
    const struct cml_body_surface *body = &report->surfaces->bodies.item[k];
    struct cml_faces *to = &drawn->faces;
    CML_TRY(grow(drawn, mesh->num_vertices, mesh->num_triangles, err));
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        const size_t facet = facet_of(report, k, mesh, i);
        drawn->face[to->num_faces + i] = (struct cml_body_face){
            k, body->first + facet, cml_body_facet_area(body, &report->scene->bodies[k], facet)};
        for (int corner = 0; corner < 3; corner++)
            to->corner[3 * (to->num_faces + i) + (size_t)corner] =
                (uint32_t)to->num_points + mesh->triangle[i][corner];
    }
    for (size_t i = 0; i < mesh->num_vertices; i++)
        cml_vec3_copy(mesh->vertex[i], to->point[to->num_points + i]);
    to->num_points += mesh->num_vertices;
    to->num_faces += mesh->num_triangles;
    return CML_OK;
}

cml_status cml_report_body_faces(const struct cml_report *report, struct cml_body_faces *drawn,
                                 struct cml_error *err)
{
    *drawn = (struct cml_body_faces){.faces.corners = 3};
    cml_status status = CML_OK;
    for (int k = 0; status == CML_OK && k < report->scene->num_bodies; k++) {
        struct cml_mesh mesh;
        status = mesh_of(report, k, &mesh, err);
        if (status != CML_OK) break;
        status = add_body(report, k, &mesh, drawn, err);
        cml_mesh_clear(&mesh);
    }
    if (status != CML_OK) cml_report_body_faces_free(drawn);
    return status;
}

void cml_report_body_faces_free(struct cml_body_faces *drawn)
{
    free(drawn->faces.point);
    free(drawn->faces.corner);
    free(drawn->face);
    *drawn = (struct cml_body_faces){0};
}
