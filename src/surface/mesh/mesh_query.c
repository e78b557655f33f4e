/* Tests a ray against triangles and the outer plane in double precision. SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_query.h"

#include "geometry/vec3.h"
#include "surface/mesh/mesh_facet.h"
#include "surface/tree/rounding.h"

#include <math.h>

/* Returns d . ((a - p) x (b - p)) for the edge from vertex i to j. The sign tells on which side of the edge
 * the ray passes; the size is twice the area of triangle (a, b, ray) seen along d. The edge is taken from the
 * lower vertex number to the higher one, so that its two triangles get exactly opposite numbers. */
static double edge_product(const struct cml_mesh_query *q, uint32_t i, uint32_t j)
{
    const double(*vertex)[3] = (const double(*)[3])q->centred->mesh.vertex;
    const bool swap = i > j;
    double a[3], b[3], c[3];
    cml_vec3_subtract(vertex[swap ? j : i], q->entry, a);
    cml_vec3_subtract(vertex[swap ? i : j], q->entry, b);
    cml_vec3_cross(a, b, c);
    const double w = cml_vec3_dot(q->direction, c);
    return swap ? -w : w;
}

/* True if an edge product may differ from 0 only by rounding; rounding.h derives the bound. err_product is a
 * bound for every edge of the mesh. A product above it needs no bound of its own, which saves sums for nearly
 * all edges. */
static bool may_be_zero(const struct cml_mesh_query *q, double product, uint32_t i, uint32_t j)
{
    if (fabs(product) > q->err_product) return false;
    const double *a = q->centred->mesh.vertex[i], *b = q->centred->mesh.vertex[j];
    double sum_a = 0, sum_b = 0, edge = 0;
    for (int k = 0; k < 3; k++) {
        sum_a += fabs(a[k] - q->entry[k]);
        sum_b += fabs(b[k] - q->entry[k]);
        edge += fabs(a[k] - b[k]);
    }
    return fabs(product) <= err_share_product * sum_a * sum_b + q->err_entry * edge;
}

/* True if a crossing is ahead of the packet. Rounding puts a packet beyond a facet by up to err_position
 * across the facet, which is 1 / |along| times as much along the ray. Near an edge at which it was reflected,
 * a packet may head into the next facet at a small angle. At a smaller angle, where walls are thinner than
 * rounding, the query is in doubt and the whole line decides. */
static bool is_ahead(struct cml_mesh_query *q, double t, double along)
{
    const double across = t * fabs(along);
    if (t >= q->t_min || (t >= q->grazing_factor * q->t_min && across >= q->t_min)) return true;
    if (t < -q->err_position && across >= -q->err_position) q->in_doubt = true;
    return false;
}

/* Returns a random number for a vertex: the first rounds of SplitMix64. open_edges checks that the triangles
 * around an edge or a vertex have all been hit at one place. For each hit triangle it adds up the number of
 * the start minus the number of the end of each edge within rounding of the ray. If all triangles were hit,
 * every number is added as often as subtracted, and the sum is 0: the ray cannot slip through between them,
 * whatever rounding did. Otherwise the sum is 0 by chance once in 2^64. (Zobrist hashing of the boundary of a
 * chain of triangles.) */
static uint64_t random_number(uint32_t vertex)
{
    const uint64_t x = (vertex + UINT64_C(1)) * UINT64_C(0x9e3779b97f4a7c15);
    return (x ^ (x >> 29)) * UINT64_C(0xbf58476d1ce4e5b9);
}

/* A ray within rounding of an edge hits the triangles on both sides, because exact signs alone would leave
 * pinholes at vertices and along the border. */
bool cml_query_intersect(struct cml_mesh_query *q, int primitive, double *t, double weight[3])
{
    const uint32_t *v = q->centred->mesh.triangle[primitive];
    const double sign = q->below ? 1 : -1;
    int close = 0;
    q->candidate_open_edges = 0;
    for (int k = 0; k < 3; k++) {
        const uint32_t i = v[(k + 1) % 3], j = v[(k + 2) % 3];
        weight[k] = sign * edge_product(q, i, j);
        if (weight[k] > q->err_product) continue;
        const bool rounding = may_be_zero(q, weight[k], i, j);
        if (!(weight[k] >= 0 || rounding)) return false;
        if (rounding) q->candidate_open_edges += random_number(i) - random_number(j);
        close += rounding;
    }
    if (close == 3) q->candidate_open_edges = 1; /* the line lies in the triangle's plane: nothing is sure */
    const double along = cml_vec3_dot(q->direction, q->centred->plane[primitive]);
    if (!(sign * along > 0)) return false;
    *t = q->t_entry + cml_facet_crossing(q->centred, primitive, q->entry, q->direction, -INFINITY);
    const double sum = weight[0] + weight[1] + weight[2];
    for (int k = 0; k < 3; k++) weight[k] = sum > 0 ? weight[k] / sum : 1.0 / 3;
    return is_ahead(q, *t, along);
}

/* Facets with a common edge or vertex share a crossing there, at the same place except for rounding. Its
 * normal is the sum of the facets' normals. Its place is computed with the facet of the lowest number, so
 * that the order of finding facets does not matter. */
void cml_query_add_hit(struct cml_mesh_query *q, int primitive, double t, const double weight[3])
{
    const bool on_edge = weight[0] < err_weight || weight[1] < err_weight || weight[2] < err_weight;
    const double *normal = q->centred->plane[primitive];
    if (q->hits_edge && on_edge && fabs(t - q->t) <= q->err_query) {
        cml_vec3_add_scaled(q->normal_sum, 1, normal, q->normal_sum);
        q->open_edges += q->candidate_open_edges;
        if (primitive > q->primitive) return;
        q->primitive = primitive;
        cml_vec3_copy(weight, q->weight);
        return;
    }
    if (t >= q->t) return;
    q->open_edges = q->candidate_open_edges;
    q->t = t;
    q->primitive = primitive;
    q->hits_edge = on_edge;
    cml_vec3_copy(normal, q->normal_sum);
    cml_vec3_copy(weight, q->weight);
}

/* True for a short ray close to the mesh, as most rays are. It needs no clipping, and t_entry = 0 is close
 * enough. */
static bool is_of_mesh_size(const struct cml_mesh_query *q)
{
    const double *lower = q->centred->lower, *upper = q->centred->upper, *p = q->origin;
    const double size = upper[0];
    return q->t < size && p[0] > lower[0] && p[0] < upper[0] && p[1] > lower[1] && p[1] < upper[1] &&
           p[2] > lower[2] - size && p[2] < upper[2] + size;
}

/* Shortens a part of the line to the inside of the mesh's box; false if nothing is left. The slab method [Kay
 * and Kajiya, Ray tracing complex scenes, SIGGRAPH 1986]. */
static bool clip_to_slabs(const struct cml_mesh_query *q, double *enter, double *leave)
{
    for (int k = 0; k < 3; k++) {
        const double lower = q->centred->lower[k] - q->origin[k], upper = q->centred->upper[k] - q->origin[k];
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

/* Also sets the bounds of rounding of the entry point and of products of lengths. */
bool cml_query_clip_ray(struct cml_mesh_query *q, double *leave)
{
    double enter = 0, size = 0;
    *leave = q->t;
    if (!is_of_mesh_size(q) && !clip_to_slabs(q, &enter, leave)) return false;
    q->t_entry = enter;
    q->err_entry = DBL_EPSILON * enter;
    for (int k = 0; k < 3; k++) {
        q->entry[k] = q->origin[k] + q->t_entry * q->direction[k];
        q->err_entry += DBL_EPSILON * (fabs(q->origin[k]) + fabs(q->entry[k]));
        size += q->centred->upper[k] - q->centred->lower[k];
    }
    q->err_product = 2 * (err_share_product * size + q->err_entry) * size;
    return true;
}

bool cml_query_enter(struct cml_mesh_query *q)
{
    double leave;
    if (!is_of_mesh_size(q)) return cml_query_clip_ray(q, &leave);
    q->t_entry = 0;
    cml_vec3_copy(q->origin, q->entry);
    return true;
}

bool cml_query_clip_line(struct cml_mesh_query *q, double *leave)
{
    q->t_entry = -INFINITY;
    *leave = INFINITY;
    if (!clip_to_slabs(q, &q->t_entry, leave)) return false;
    cml_vec3_add_scaled(q->origin, q->t_entry, q->direction, q->entry);
    return true;
}

/* Says whether (x, y) lies inside the mesh's border, outside, or within distance d of it, where rounding
 * leaves the side open. The bounding box decides most points at once. */
enum cml_border_side cml_query_border_side(const struct cml_mesh_query *q, double x, double y, double d)
{
    const double *lower = q->centred->lower, *upper = q->centred->upper;
    if (x < lower[0] - d || x > upper[0] + d || y < lower[1] - d || y > upper[1] + d)
        return CML_OUTSIDE_BORDER;
    if (cml_footprint_border_is_near(q->centred->footprint, x, y, d)) return CML_AT_BORDER;
    return cml_footprint_contains(q->centred->footprint, x, y) ? CML_INSIDE_BORDER : CML_OUTSIDE_BORDER;
}

/* The plane begins within rounding of the border, as the triangles there end: both cover the border, so there
 * is no gap. */
void cml_query_intersect_outer_plane(struct cml_mesh_query *q)
{
    const double uz = q->direction[2];
    if (q->centred->mesh.closed || q->exclude == CML_OUTER_PLANE || !(q->below ? uz < 0 : uz > 0)) return;
    const double t = (q->centred->mesh.z_border - q->origin[2]) / uz;
    if (!is_ahead(q, t, uz) || !(t < q->t)) return;
    const double x = q->origin[0] + t * q->direction[0], y = q->origin[1] + t * q->direction[1];
    const enum cml_border_side side = cml_query_border_side(q, x, y, fmax(q->err_position, q->err_entry));
    if (side == CML_INSIDE_BORDER) return;
    q->in_doubt = q->in_doubt || side == CML_AT_BORDER;
    q->t = t;
    q->primitive = CML_OUTER_PLANE;
}

/* Computes the upward normal of the cone that a tessellated heightfield's triangle approximates. */
static void analytic_normal(const struct cml_mesh_query *q, const double point[3], double normal[3])
{
    const double x = point[0] - q->centred->axis[0], y = point[1] - q->centred->axis[1],
                 r = sqrt(x * x + y * y);
    const double m = q->centred->mesh.slope[q->primitive], k = 1 / sqrt(1 + m * m);
    normal[0] = r > 0 ? m * k * x / r : 0;
    normal[1] = r > 0 ? m * k * y / r : 0;
    normal[2] = r > 0 ? -k : -1;
}

/* Interpolates vertex normals as in Phong shading [Communications of the ACM 18 (6), 1975]. */
static void interpolated_normal(const struct cml_mesh_query *q, double normal[3])
{
    const struct cml_mesh *mesh = &q->centred->mesh;
    const uint32_t *v = mesh->triangle[q->primitive];
    for (int k = 0; k < 3; k++)
        normal[k] = q->weight[0] * mesh->vertex_normal[v[0]][k] +
                    q->weight[1] * mesh->vertex_normal[v[1]][k] + q->weight[2] * mesh->vertex_normal[v[2]][k];
    cml_vec3_normalise(normal);
}

/* True if the packet comes from another facet in the bottom of a groove (rule P5). */
static bool is_in_groove(const struct cml_mesh_query *q)
{
    double area[3], longest = 0;
    if (q->exclude < 0) return false;
    for (int k = 0; k < 3; k++) {
        double edge[3];
        cml_vec3_subtract(cml_centred_corner(q->centred, q->primitive, (k + 1) % 3),
                          cml_centred_corner(q->centred, q->primitive, k), edge);
        longest = fmax(longest, cml_vec3_dot(edge, edge));
    }
    cml_vec3_area(cml_centred_corner(q->centred, q->primitive, 0),
                  cml_centred_corner(q->centred, q->primitive, 1),
                  cml_centred_corner(q->centred, q->primitive, 2), area);
    const double height = sqrt(cml_vec3_dot(area, area) / longest);
    return q->t <= fmax(CML_GROOVE_SHARE * height, q->err_query);
}

/* Sets the normals of a crossing (rule P1). At a vertex both are the angle-weighted mean normal, on an edge
 * the mean of its facets' normals, because no single facet can decide there. If the mean turns away from the
 * ray, it would reflect the packet into the boundary; then the facet's own normal is used. */
static void fill_normals(const struct cml_mesh_query *q, const double point[3],
                         struct cml_mesh_crossing *crossing)
{
    const struct cml_mesh *mesh = &q->centred->mesh;
    int corner = -1;
    for (int k = 0; k < 3; k++)
        if (q->weight[k] > 1 - 2 * err_weight) corner = k;
    cml_vec3_copy(corner >= 0 ? mesh->vertex_normal[mesh->triangle[q->primitive][corner]] : q->normal_sum,
                  crossing->facet);
    const double sign = q->below ? 1 : -1;
    const bool turned = !(sign * cml_vec3_dot(q->direction, crossing->facet) > 0);
    if (turned)
        cml_vec3_copy(q->centred->plane[q->primitive], crossing->facet);
    else if (q->hits_edge || corner >= 0)
        cml_vec3_normalise(crossing->facet);
    cml_vec3_copy(crossing->facet, crossing->normal);
    if (q->hits_edge) return;
    if (mesh->normals == CML_NORMALS_ANALYTIC)
        analytic_normal(q, point, crossing->normal);
    else if (mesh->normals == CML_NORMALS_VERTEX && !is_in_groove(q))
        interpolated_normal(q, crossing->normal);
}

/* Returns the distance along the query's line to a primitive's plane. The distance is computed from a corner
 * of the facet, not from the origin of the centred frame as in cml_query_plane_distance. This is more precise
 * if the packet stands on the plane. */
static double distance_to_primitive(const struct cml_mesh_query *q, int primitive)
{
    const struct cml_mesh *mesh = &q->centred->mesh;
    if (primitive == CML_OUTER_PLANE) return (mesh->z_border - q->origin[2]) / q->direction[2];
    double to_plane[3];
    cml_vec3_subtract(cml_centred_corner(q->centred, primitive, 0), q->origin, to_plane);
    return cml_vec3_dot(to_plane, q->centred->plane[primitive]) /
           cml_vec3_dot(q->direction, q->centred->plane[primitive]);
}

double cml_query_plane_distance(const struct cml_mesh_query *q, int primitive)
{
    const double *plane = q->centred->plane[primitive];
    return (plane[3] - cml_vec3_dot(q->origin, plane)) / cml_vec3_dot(q->direction, plane);
}

void cml_query_test_contact(struct cml_mesh_query *q, int primitive)
{
    const double *plane = q->centred->plane[primitive];
    if (fabs(plane[3] - cml_vec3_dot(q->origin, plane)) <= q->contact_distance) q->in_doubt = true;
}

void cml_query_add_inner_hit(struct cml_mesh_query *q, int primitive, const double normal[3], double t,
                             const double weight[3])
{
    if (!(t < q->t)) return;
    q->t = t;
    q->primitive = primitive;
    q->hits_edge = false;
    q->open_edges = 0;
    cml_vec3_copy(normal, q->normal_sum);
    cml_vec3_copy(weight, q->weight);
}

/* True if the origin is over the mesh's box. The box is larger than the mesh by err_float, which is more than
 * rounding. */
static bool is_over_box(const struct cml_mesh_query *q)
{
    const double *lower = q->centred->lower, *upper = q->centred->upper, *p = q->origin;
    return p[0] > lower[0] && p[0] < upper[0] && p[1] > lower[1] && p[1] < upper[1];
}

/* True if the packet may stand beyond a neighbouring facet that it has not met, because it is close to an
 * edge of its facet `primitive` or to the mesh's border. Rounding may have put the packet there, or a
 * refraction at the mean normal of several facets. weight[k] is twice the area of the triangle between the
 * packet and edge k, so the packet's distance from the edge is at least weight[k] / length. A rounding error
 * across the facet is 1 / |along| times as large along the facet. */
static bool is_near_edge(const struct cml_mesh_query *q, int primitive)
{
    if (primitive < 0) return primitive == CML_NEAR_FACETS;
    if (primitive == CML_OUTER_PLANE)
        return is_over_box(q) &&
               cml_query_border_side(q, q->origin[0], q->origin[1], q->err_query) != CML_OUTSIDE_BORDER;
    const double *normal = q->centred->plane[primitive], along = fabs(cml_vec3_dot(q->direction, normal));
    double weight[3], sum = 0;
    for (int k = 0; k < 3; k++) {
        const double *a = cml_centred_corner(q->centred, primitive, k);
        double edge[3], from[3], part[3];
        cml_vec3_subtract(cml_centred_corner(q->centred, primitive, (k + 1) % 3), a, edge);
        cml_vec3_subtract(q->origin, a, from);
        cml_vec3_cross(edge, from, part);
        const double length = fabs(edge[0]) + fabs(edge[1]) + fabs(edge[2]);
        weight[k] = cml_vec3_dot(part, normal);
        sum += weight[k];
        if (!(along * weight[k] > q->err_query * length)) return true;
    }
    return weight[0] < err_weight * sum || weight[1] < err_weight * sum || weight[2] < err_weight * sum;
}

/* Barycentric weights come from the areas opposite to the corners. Rounding may put the place beside the
 * facet; a negative area counts as 0. */
void cml_query_set_hit(struct cml_mesh_query *q, int primitive, double t)
{
    double area[3] = {1, 1, 1}, place[3];
    q->t = t;
    q->primitive = primitive;
    q->hits_edge = false;
    if (primitive == CML_OUTER_PLANE) return;
    cml_vec3_copy(q->centred->plane[primitive], q->normal_sum);
    cml_vec3_add_scaled(q->origin, t, q->direction, place);
    for (int k = 0; k < 3; k++) {
        double normal[3];
        cml_vec3_area(place, cml_centred_corner(q->centred, primitive, (k + 1) % 3),
                      cml_centred_corner(q->centred, primitive, (k + 2) % 3), normal);
        area[k] = fmax(0, cml_vec3_dot(normal, q->centred->plane[primitive]));
    }
    for (int k = 0; k < 3; k++) q->weight[k] = area[k] / (area[0] + area[1] + area[2]);
}

/* A packet that came undeflected through its facet has already met what lies before the facet, so such
 * crossings do not count. */
void cml_query_begin(struct cml_mesh_query *q, const struct cml_centred_mesh *centred, const double p[3],
                     const double u[3], int below, double t_max, int exclude, int undeflected,
                     double err_position)
{
    q->centred = centred;
    q->below = below;
    q->exclude = exclude;
    q->t = t_max;
    q->err_position = err_position;
    q->err_query = err_position + centred->err_mesh;
    q->primitive = -1;
    q->hits_edge = false;
    q->err_entry = 0;
    cml_vec3_subtract(p, centred->centre, q->origin);
    cml_vec3_copy(u, q->direction);
    q->starts_on_edge = is_near_edge(q, exclude);
    q->in_doubt = false;
    q->open_edges = 0;
    q->contact_distance = exclude == -1 || exclude == CML_OFF_FACETS ? q->err_query : -1;
    q->grazing_factor = exclude >= 0 && undeflected ? 1 : err_grazing_factor;
    q->t_min = exclude >= 0 && undeflected
                   ? fmax(-err_position, fmin(distance_to_primitive(q, exclude), err_position))
                   : -err_position;
}

bool cml_query_is_doubtful(const struct cml_mesh_query *q)
{
    return q->starts_on_edge || q->in_doubt || q->open_edges != 0 ||
           (q->primitive >= 0 && q->t < q->err_query) ||
           (q->centred->mesh.unite && (q->primitive >= 0 || q->exclude >= 0));
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
        crossing->point[2] = q->centred->mesh.z_border + q->centred->centre[2];
    else
        fill_normals(q, local, crossing);
    return 1;
}
