/* SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_line.h"

#include "surface/mesh/mesh_facet.h"
#include "geometry/predicate.h"
#include "geometry/vec3.h"

#include <math.h>

void cml_line_begin(struct cml_mesh_line *line, const struct cml_mesh_query *q, double t_max)
{
    *line = (struct cml_mesh_line){.q = q,
                                   .near = 4 * q->reach,
                                   .t = INFINITY,
                                   .primitive = -1,
                                   .back = INFINITY,
                                   .exit_t = INFINITY,
                                   .beside = INFINITY,
                                   .exit = -1,
                                   .length = t_max};
    for (int k = 0; k < 3; k++) line->from[k] = q->origin[k] + q->reach * q->direction[k];
}

/* On which side of an edge the line passes; from the lower index to the higher, so that the triangles of an
 * edge get opposite signs. */
static int side_of_edge(const struct cml_mesh_line *line, uint32_t i, uint32_t j)
{
    const double(*vertex)[3] = (const double(*)[3])line->q->body->mesh.vertex;
    return i < j ? cml_line_side(vertex[i], vertex[j], line->from, line->q->direction)
                 : -cml_line_side(vertex[j], vertex[i], line->from, line->q->direction);
}

/* +1 when the line crosses the triangle upwards, -1 downwards, else 0. */
static int crosses(const struct cml_mesh_line *line, const uint32_t v[3])
{
    const int side = side_of_edge(line, v[0], v[1]);
    return side_of_edge(line, v[1], v[2]) == side && side_of_edge(line, v[2], v[0]) == side ? side : 0;
}

static bool leads_away(const struct cml_mesh_query *q, double along)
{
    return q->below ? along > 0 : along < 0;
}

static double distance_to_outer_plane(const struct cml_mesh_query *q, const double p[3], double near)
{
    const bool is_apart = cml_query_border_side(q, p[0], p[1], near) == CML_INSIDE_BORDER;
    return is_apart ? INFINITY : fabs(q->body->mesh.z_border - p[2]);
}

static double distance_to(const struct cml_mesh_query *q, int primitive, double least)
{
    return cml_facet_crossing(q->body, primitive, q->origin, q->direction, least);
}

/* A crossing ahead, at distance t. */
static void add_ahead(struct cml_mesh_line *line, int primitive, int way, double t)
{
    const struct cml_mesh_query *q = line->q;
    line->winding_ahead += way;
    if (!leads_away(q, way)) {
        const double from = primitive == CML_OUTER_PLANE ? distance_to_outer_plane(q, q->origin, line->near)
                                                         : cml_facet_distance(q->body, primitive, q->origin);
        line->back = fmin(line->back, from);
    } else if (t < line->t) {
        line->t = t;
        line->primitive = primitive;
    }
}

/* A place of the line ahead and its distance from a facet that leads away: the first of those that rounding
 * can explain is the exit. */
static void add_exit_at(struct cml_mesh_line *line, int primitive, double t)
{
    const struct cml_mesh_query *q = line->q;
    double place[3];
    for (int k = 0; k < 3; k++) place[k] = q->origin[k] + t * q->direction[k];
    const double beside = cml_facet_distance(q->body, primitive, place);
    if (!(beside <= line->near) || t + beside >= line->exit_t + line->beside) return;
    line->exit_t = t;
    line->beside = beside;
    line->exit = primitive;
}

/* Where the line passes a facet that leads away from the packet's side: it meets it, or is closest to it at
 * an edge or at its beginning. Its plane alone does not tell: between steep walls a line that begins beyond
 * both meets their planes far from where they end. */
static void add_exit(struct cml_mesh_line *line, int primitive, double t)
{
    const struct cml_mesh_query *q = line->q;
    const struct cml_mesh *mesh = &q->body->mesh;
    const uint32_t *v = mesh->triangle[primitive];
    double first = INFINITY;
    for (int k = 0; k < 3; k++) {
        double to_corner[3];
        cml_vec3_subtract(mesh->vertex[v[k]], q->origin, to_corner);
        first = fmin(first, cml_vec3_dot(to_corner, q->direction));
    }
    if (first > line->exit_t + line->near) return;
    add_exit_at(line, primitive, 0);
    add_exit_at(line, primitive, fmax(0, t));
    for (int k = 0; k < 3; k++) {
        const double *a = mesh->vertex[v[k]], *b = mesh->vertex[v[(k + 1) % 3]];
        add_exit_at(line, primitive, cml_ray_closest_to_edge(q->origin, q->direction, a, b));
    }
}

/* A packet that interacts beside an edge may be beyond it, and leave where no line meets a facet. */
static void add_end(struct cml_mesh_line *line, int primitive, double height)
{
    const struct cml_mesh_query *q = line->q;
    const double left = height - line->length * cml_vec3_dot(q->direction, q->body->plane[primitive]);
    double end[3];
    if (line->ends_beside || !(fabs(left) <= line->near)) return;
    for (int k = 0; k < 3; k++) end[k] = q->origin[k] + line->length * q->direction[k];
    line->ends_beside = cml_facet_distance(q->body, primitive, end) <= line->near;
}

void cml_line_add(struct cml_mesh_line *line, int primitive)
{
    const struct cml_mesh_query *q = line->q;
    const struct cml_mesh *mesh = &q->body->mesh;
    const uint32_t *v = mesh->triangle[primitive];
    const double *a = mesh->vertex[v[0]], *b = mesh->vertex[v[1]], *c = mesh->vertex[v[2]];
    const double *normal = q->body->plane[primitive];
    double to_corner[3];
    cml_vec3_subtract(a, q->origin, to_corner);
    const double height = cml_vec3_dot(to_corner, normal);
    const int way = crosses(line, v);
    const bool ahead = way != 0 && way * cml_plane_side(a, b, c, line->from) > 0,
               may_exit = leads_away(q, cml_vec3_dot(q->direction, normal));
    line->winding += way;
    if (ahead) add_ahead(line, primitive, way, distance_to(q, primitive, q->reach));
    if (may_exit) add_exit(line, primitive, distance_to(q, primitive, -INFINITY));
    add_end(line, primitive, height);
}

/* As add_exit_at, for the outer plane. */
static void add_outer_exit_at(struct cml_mesh_line *line, double t)
{
    const struct cml_mesh_query *q = line->q;
    double place[3];
    for (int k = 0; k < 3; k++) place[k] = q->origin[k] + t * q->direction[k];
    const double beside = distance_to_outer_plane(q, place, line->near);
    if (!(beside <= line->near) || t + beside >= line->exit_t + line->beside) return;
    line->exit_t = t;
    line->beside = beside;
    line->exit = CML_OUTER_PLANE;
}

/* Whether the line still has the outer plane ahead, when it has been moved as cml_plane_side moves it. */
static bool outer_plane_is_ahead(const struct cml_mesh_line *line)
{
    const double height = line->q->body->mesh.z_border - line->from[2], uz = line->q->direction[2];
    return height != 0 ? (height > 0) == (uz > 0) : uz < 0;
}

/* The outer plane is crossed where the sheet alone does not lead from one side to the other. A line that
 * grazes it may pass its border a little beyond it. */
static void add_outer_plane(struct cml_mesh_line *line)
{
    const struct cml_mesh_query *q = line->q;
    const double height = q->body->mesh.z_border - q->origin[2], uz = q->direction[2];
    const double t = height / uz, later = t + line->near / (2 * fabs(uz));
    const int way = uz < 0 ? 1 : -1;
    if (uz == 0) return;
    if (line->winding != way && outer_plane_is_ahead(line))
        add_ahead(line, CML_OUTER_PLANE, way, fmax(t, q->reach));
    if (!leads_away(q, way)) return;
    add_outer_exit_at(line, fmax(0, t));
    add_outer_exit_at(line, fmax(0, later));
}

/* Whether the packet's position, or what is just ahead of it, lies below the boundary. */
static bool lies_below(const struct cml_mesh_line *line)
{
    const double uz = line->q->direction[2];
    const bool ends_below = uz != 0 ? uz > 0 : line->q->origin[2] >= line->q->body->mesh.z_border;
    return ends_below + line->winding_ahead > 0;
}

void cml_line_decide(struct cml_mesh_line *line, struct cml_mesh_query *q)
{
    const double t_max = line->length;
    add_outer_plane(line);
    if (lies_below(line) != (q->below != 0) && line->back > line->near && line->exit >= 0) {
        line->t = line->exit_t;
        line->primitive = line->exit;
    }
    const bool same_place = q->primitive >= 0 && fabs(fmax(q->t, 0) - line->t) <= q->reach;
    if (line->primitive >= 0 && line->t < t_max && same_place) return;
    q->t = t_max;
    q->primitive = -1;
    if (line->primitive >= 0 && line->t < t_max) cml_query_take_settled(q, line->primitive, line->t);
}
