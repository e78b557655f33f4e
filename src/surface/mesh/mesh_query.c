/* SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_query.h"

#include "surface/mesh/mesh_facet.h"
#include "geometry/vec3.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* Below this share of a triangle's area a barycentric weight counts as 0: the hit lies on the opposite edge.
 */
static const double on_edge = 1e-12;

/* d . ((a - p) x (b - p)) of the edge from vertex i to j. Computed from the lower index to the higher, so
 * that the two triangles of an edge get exactly opposite numbers. */
static double edge_product(const struct cml_mesh_query *q, uint32_t i, uint32_t j)
{
    const double(*vertex)[3] = (const double(*)[3])q->body->mesh.vertex;
    const bool swap = i > j;
    double a[3], b[3], c[3];
    cml_vec3_subtract(vertex[swap ? j : i], q->near, a);
    cml_vec3_subtract(vertex[swap ? i : j], q->near, b);
    cml_vec3_cross(a, b, c);
    const double w = cml_vec3_dot(q->direction, c);
    return swap ? -w : w;
}

/* Whether an edge product may be 0 but for rounding. */
static bool is_rounding(const struct cml_mesh_query *q, double product, uint32_t i, uint32_t j)
{
    if (fabs(product) > q->coarse) return false;
    const double *a = q->body->mesh.vertex[i], *b = q->body->mesh.vertex[j];
    double sum_a = 0, sum_b = 0, edge = 0;
    for (int k = 0; k < 3; k++) {
        sum_a += fabs(a[k] - q->near[k]);
        sum_b += fabs(b[k] - q->near[k]);
        edge += fabs(a[k] - b[k]);
    }
    return fabs(product) <= 4 * DBL_EPSILON * sum_a * sum_b + q->blur * edge;
}

/* Whether a crossing at t is not behind the packet. Rounding puts a packet beyond a facet by up to slack
 * across it, which is more along it: beside an edge at which it has turned, a packet may head into the next
 * facet. */
bool cml_query_is_ahead(const struct cml_mesh_query *q, double t, double along)
{
    return t >= q->least || (t >= q->lenience * q->least && t * fabs(along) >= q->least);
}

/* A random number of a vertex. */
static uint64_t number_of(uint32_t vertex)
{
    const uint64_t x = (vertex + UINT64_C(1)) * UINT64_C(0x9e3779b97f4a7c15);
    return (x ^ (x >> 29)) * UINT64_C(0xbf58476d1ce4e5b9);
}

/* Crossing of one triangle away from the packet's side; on success *t and the barycentric weights. A ray
 * within rounding of an edge meets the triangles on both sides of it: exact signs alone leave pinholes at
 * vertices, where the signs of several edges have to agree, and along the border, beyond which the plane
 * begins. */
bool cml_query_cross(struct cml_mesh_query *q, int primitive, double *t, double weight[3])
{
    const uint32_t *v = q->body->mesh.triangle[primitive];
    const double sign = q->below ? 1 : -1;
    int close = 0;
    q->candidate_open = 0;
    for (int k = 0; k < 3; k++) {
        const uint32_t i = v[(k + 1) % 3], j = v[(k + 2) % 3];
        weight[k] = sign * edge_product(q, i, j);
        if (weight[k] > q->coarse) continue;
        const bool rounding = is_rounding(q, weight[k], i, j);
        if (!(weight[k] >= 0 || rounding)) return false;
        if (rounding) q->candidate_open += number_of(i) - number_of(j);
        close += rounding;
    }
    if (close == 3) q->candidate_open = 1; /* the line lies in the plane: nothing is sure */
    const double along = cml_vec3_dot(q->direction, q->body->plane[primitive]);
    if (!(sign * along > 0)) return false;
    *t = q->base + cml_facet_crossing(q->body, primitive, q->near, q->direction, -INFINITY);
    const double sum = weight[0] + weight[1] + weight[2];
    for (int k = 0; k < 3; k++) weight[k] = sum > 0 ? weight[k] / sum : 1.0 / 3;
    return cml_query_is_ahead(q, *t, along);
}

/* The best crossing so far. One at the same place, on a shared edge, adds its facet to the seam's mean
 * normal. */
void cml_query_take(struct cml_mesh_query *q, int primitive, double t, const double weight[3])
{
    const bool seam = weight[0] < on_edge || weight[1] < on_edge || weight[2] < on_edge;
    const double *normal = q->body->plane[primitive];
    if (q->on_seam && seam && fabs(t - q->t) <= q->reach) {
        for (int k = 0; k < 3; k++) q->seam[k] += normal[k];
        q->open += q->candidate_open;
        return;
    }
    if (t >= q->t) return;
    q->open = q->candidate_open;
    q->t = t;
    q->primitive = primitive;
    q->on_seam = seam;
    for (int k = 0; k < 3; k++) {
        q->seam[k] = normal[k];
        q->weight[k] = weight[k];
    }
}

/* Most rays are short and start close to the mesh: nothing to clip. */
static bool is_of_mesh_size(const struct cml_mesh_query *q, double t_max)
{
    const double *lower = q->body->lower, *upper = q->body->upper, *p = q->origin;
    const double size = upper[0];
    return t_max < size && p[0] > lower[0] && p[0] < upper[0] && p[1] > lower[1] && p[1] < upper[1] &&
           p[2] > lower[2] - size && p[2] < upper[2] + size;
}

/* Shortens a part of the line to what is inside the mesh's box; false when nothing is. */
static bool clip_to_box(const struct cml_mesh_query *q, double *enter, double *leave)
{
    for (int k = 0; k < 3; k++) {
        const double lower = q->body->lower[k] - q->origin[k], upper = q->body->upper[k] - q->origin[k];
        if (q->direction[k] == 0) {
            if (lower > 0 || upper < 0) return false;
            continue;
        }
        const double a = lower / q->direction[k], b = upper / q->direction[k];
        const double first = a < b ? a : b, last = a < b ? b : a;
        if (first > *enter) *enter = first;
        if (last < *leave) *leave = last;
    }
    return *enter <= *leave;
}

/* The part of the ray inside the mesh's box, so that only numbers of the mesh's own size are rounded to
 * float. */
static bool clip(const struct cml_mesh_query *q, double t_max, double *enter, double *leave)
{
    *enter = 0;
    *leave = t_max;
    return is_of_mesh_size(q, t_max) || clip_to_box(q, enter, leave);
}

bool cml_query_approach(struct cml_mesh_query *q, double back, double *leave)
{
    double enter, size = 0;
    if (!clip(q, q->t, &enter, leave)) return false;
    q->base = enter - back;
    q->blur = DBL_EPSILON * enter;
    for (int k = 0; k < 3; k++) {
        q->near[k] = q->origin[k] + q->base * q->direction[k];
        q->blur += DBL_EPSILON * (fabs(q->origin[k]) + fabs(q->near[k]));
        size += q->body->upper[k] - q->body->lower[k];
    }
    q->coarse = 2 * (4 * DBL_EPSILON * size + q->blur) * size;
    return true;
}

bool cml_query_approach_all(struct cml_mesh_query *q, double *leave)
{
    q->base = -INFINITY;
    *leave = INFINITY;
    if (!clip_to_box(q, &q->base, leave)) return false;
    for (int k = 0; k < 3; k++) q->near[k] = q->origin[k] + q->base * q->direction[k];
    return true;
}

enum cml_border_side cml_query_border_side(const struct cml_mesh_query *q, double x, double y, double d)
{
    if (cml_footprint_border_is_near(q->body->footprint, x, y, d)) return CML_AT_BORDER;
    return cml_footprint_contains(q->body->footprint, x, y) ? CML_INSIDE_BORDER : CML_OUTSIDE_BORDER;
}

/* The plane outside the footprint, and within rounding of its border, as the triangles there reach as far. */
void cml_query_outer_plane(struct cml_mesh_query *q)
{
    const double uz = q->direction[2];
    if (q->exclude == CML_OUTER_PLANE || !(q->below ? uz < 0 : uz > 0)) return;
    const double t = (q->body->mesh.z_border - q->origin[2]) / uz;
    if (!cml_query_is_ahead(q, t, uz) || !(t < q->t)) return;
    const double x = q->origin[0] + t * q->direction[0], y = q->origin[1] + t * q->direction[1];
    const enum cml_border_side side = cml_query_border_side(q, x, y, fmax(q->slack, q->blur));
    if (side == CML_INSIDE_BORDER) return;
    q->doubt = q->doubt || side == CML_AT_BORDER;
    q->t = t;
    q->primitive = CML_OUTER_PLANE;
}

/* Sine of the angle to the outer plane below which single precision may not tell on which side of the border
 * it is met. */
static const double grazing_border = 1e-2;

/* The border belongs to triangles and plane alike, but only the plane asks for it in double: a ray that
 * passes within the rounding of single precision of it may have been let through by both. */
bool cml_query_may_have_missed(const struct cml_mesh_query *q)
{
    const double uz = q->direction[2], d = q->body->inflation;
    if (!(q->below ? uz < 0 : uz > 0)) return false;
    const double end = q->origin[2] + q->t * uz;
    if (q->below ? end < q->body->lower[2] : end > q->body->upper[2]) return true;
    const double t = (q->body->mesh.z_border - q->origin[2]) / uz;
    if (!(t >= q->least) || !(t < q->t)) return false;
    if (fabs(uz) < grazing_border) return true;
    const double x = q->origin[0] + t * q->direction[0], y = q->origin[1] + t * q->direction[1];
    return cml_query_border_side(q, x, y, d) == CML_AT_BORDER;
}

static void normalise(double v[3])
{
    const double k = 1 / sqrt(cml_vec3_dot(v, v));
    for (int i = 0; i < 3; i++) v[i] *= k;
}

/* Upward normal of the cone that the triangle stands for. */
static void analytic_normal(const struct cml_mesh_query *q, const double point[3], double normal[3])
{
    const double x = point[0] - q->body->axis[0], y = point[1] - q->body->axis[1], r = sqrt(x * x + y * y);
    const double m = q->body->mesh.slope[q->primitive], k = 1 / sqrt(1 + m * m);
    normal[0] = r > 0 ? m * k * x / r : 0;
    normal[1] = r > 0 ? m * k * y / r : 0;
    normal[2] = r > 0 ? -k : -1;
}

static void interpolated_normal(const struct cml_mesh_query *q, double normal[3])
{
    const struct cml_mesh *mesh = &q->body->mesh;
    const uint32_t *v = mesh->triangle[q->primitive];
    for (int k = 0; k < 3; k++)
        normal[k] = q->weight[0] * mesh->vertex_normal[v[0]][k] +
                    q->weight[1] * mesh->vertex_normal[v[1]][k] + q->weight[2] * mesh->vertex_normal[v[2]][k];
    normalise(normal);
}

/* P1: at a vertex the angle-weighted mean normal, on an edge the mean of its facets; there it is the facet as
 * well, for no single facet can decide. Elsewhere facet and normal are what their names say. */
static void fill_normals(const struct cml_mesh_query *q, const double point[3],
                         struct cml_mesh_crossing *crossing)
{
    const struct cml_mesh *mesh = &q->body->mesh;
    int corner = -1;
    for (int k = 0; k < 3; k++)
        if (q->weight[k] > 1 - 2 * on_edge) corner = k;
    for (int k = 0; k < 3; k++)
        crossing->facet[k] =
            corner >= 0 ? mesh->vertex_normal[mesh->triangle[q->primitive][corner]][k] : q->seam[k];
    const double sign = q->below ? 1 : -1;
    const bool away = !(sign * cml_vec3_dot(q->direction, crossing->facet) > 0); /* as a mean may turn */
    if (away)
        for (int k = 0; k < 3; k++) crossing->facet[k] = q->body->plane[q->primitive][k];
    else if (q->on_seam || corner >= 0)
        normalise(crossing->facet);
    for (int k = 0; k < 3; k++) crossing->normal[k] = crossing->facet[k];
    if (q->on_seam) return;
    if (mesh->normals == CML_NORMALS_ANALYTIC)
        analytic_normal(q, point, crossing->normal);
    else if (mesh->normals == CML_NORMALS_VERTEX)
        interpolated_normal(q, crossing->normal);
}

/* Distance along the query's line to the plane of a primitive. */
static double plane_distance(const struct cml_mesh_query *q, int primitive)
{
    const struct cml_mesh *mesh = &q->body->mesh;
    if (primitive == CML_OUTER_PLANE) return (mesh->z_border - q->origin[2]) / q->direction[2];
    double to_plane[3];
    cml_vec3_subtract(mesh->vertex[mesh->triangle[primitive][0]], q->origin, to_plane);
    return cml_vec3_dot(to_plane, q->body->plane[primitive]) /
           cml_vec3_dot(q->direction, q->body->plane[primitive]);
}

/* Distance in double along the ray from the triangle's plane alone; `along` is the product of direction and
 * unit normal. */
double cml_query_facet_distance(const struct cml_mesh_query *q, int primitive, double *along)
{
    const double *plane = q->body->plane[primitive];
    *along = cml_vec3_dot(q->direction, plane);
    return (plane[3] - cml_vec3_dot(q->origin, plane)) / *along;
}

void cml_query_feel(struct cml_mesh_query *q, int primitive)
{
    const double *plane = q->body->plane[primitive];
    if (fabs(plane[3] - cml_vec3_dot(q->origin, plane)) <= q->touch) q->doubt = true;
}

void cml_query_take_inside(struct cml_mesh_query *q, int primitive, const double normal[3], double t,
                           const double weight[3])
{
    if (!(t < q->t)) return;
    q->t = t;
    q->primitive = primitive;
    q->on_seam = false;
    q->open = 0;
    for (int k = 0; k < 3; k++) {
        q->seam[k] = normal[k];
        q->weight[k] = weight[k];
    }
}

/* Inflation counts: it is more than rounding. */
static bool is_over_box(const struct cml_mesh_query *q)
{
    const double *lower = q->body->lower, *upper = q->body->upper, *p = q->origin;
    return p[0] > lower[0] && p[0] < upper[0] && p[1] > lower[1] && p[1] < upper[1];
}

/* Whether the packet stands so close to an edge of its facet, or to the border, that rounding may have put it
 * beyond facets that it has not met, or that it was turned by a mean normal. What rounding moves across a
 * facet is more along it, where the packet grazes it. */
static bool stands_on_edge(const struct cml_mesh_query *q, int primitive)
{
    if (primitive < 0) return primitive == CML_BESIDE_FACETS;
    if (primitive == CML_OUTER_PLANE)
        return is_over_box(q) &&
               cml_query_border_side(q, q->origin[0], q->origin[1], q->reach) != CML_OUTSIDE_BORDER;
    const struct cml_mesh *mesh = &q->body->mesh;
    const double *normal = q->body->plane[primitive], along = fabs(cml_vec3_dot(q->direction, normal));
    double weight[3], sum = 0;
    for (int k = 0; k < 3; k++) {
        const double *a = mesh->vertex[mesh->triangle[primitive][k]];
        double edge[3], from[3], part[3];
        cml_vec3_subtract(mesh->vertex[mesh->triangle[primitive][(k + 1) % 3]], a, edge);
        cml_vec3_subtract(q->origin, a, from);
        cml_vec3_cross(edge, from, part);
        const double length = fabs(edge[0]) + fabs(edge[1]) + fabs(edge[2]);
        weight[k] = cml_vec3_dot(part, normal);
        sum += weight[k];
        if (!(along * weight[k] > q->reach * length)) return true;
    }
    return weight[0] < on_edge * sum || weight[1] < on_edge * sum || weight[2] < on_edge * sum;
}

void cml_query_take_settled(struct cml_mesh_query *q, int primitive, double t)
{
    double area[3] = {1, 1, 1};
    q->t = t;
    q->primitive = primitive;
    q->on_seam = false;
    if (primitive == CML_OUTER_PLANE) return;
    const struct cml_mesh *mesh = &q->body->mesh;
    const double *normal = q->body->plane[primitive];
    for (int k = 0; k < 3; k++) {
        double a[3], b[3], part[3];
        for (int i = 0; i < 3; i++) {
            const double at = q->origin[i] + t * q->direction[i];
            a[i] = mesh->vertex[mesh->triangle[primitive][(k + 1) % 3]][i] - at;
            b[i] = mesh->vertex[mesh->triangle[primitive][(k + 2) % 3]][i] - at;
        }
        cml_vec3_cross(a, b, part);
        area[k] = fmax(0, cml_vec3_dot(part, normal));
        q->seam[k] = normal[k];
    }
    for (int k = 0; k < 3; k++) q->weight[k] = area[k] / (area[0] + area[1] + area[2]);
}

void cml_query_begin(struct cml_mesh_query *q, const struct cml_mesh_body *body, const double p[3],
                     const double u[3], int below, double t_max, int exclude, int straight, double slack)
{
    q->body = body;
    q->below = below;
    q->exclude = exclude;
    q->t = t_max;
    q->slack = slack;
    q->reach = slack + body->digits;
    q->primitive = -1;
    q->on_seam = false;
    q->blur = 0;
    cml_vec3_subtract(p, body->centre, q->origin);
    for (int k = 0; k < 3; k++) q->direction[k] = u[k];
    q->on_edge = stands_on_edge(q, exclude);
    q->doubt = false;
    q->open = 0;
    q->touch = exclude == -1 ? q->reach : -1;
    q->lenience = exclude >= 0 && straight ? 1 : 32;
    q->least = exclude >= 0 && straight ? fmax(-slack, fmin(plane_distance(q, exclude), slack)) : -slack;
}

bool cml_query_is_doubtful(const struct cml_mesh_query *q)
{
    return q->on_edge || q->doubt || q->open != 0 || (q->primitive >= 0 && q->t < q->reach);
}

int cml_query_finish(const struct cml_mesh_query *q, const double p[3], const double u[3],
                     struct cml_mesh_crossing *crossing)
{
    double local[3];
    if (q->primitive < 0) return 0;
    crossing->t = q->t > 0 ? q->t : 0;
    crossing->primitive = q->primitive;
    for (int k = 0; k < 3; k++) {
        local[k] = q->origin[k] + crossing->t * u[k];
        crossing->point[k] = p[k] + crossing->t * u[k];
        crossing->normal[k] = crossing->facet[k] = k == 2 ? -1 : 0;
    }
    if (q->primitive == CML_OUTER_PLANE)
        crossing->point[2] = q->body->mesh.z_border + q->body->centre[2];
    else
        fill_normals(q, local, crossing);
    return 1;
}
