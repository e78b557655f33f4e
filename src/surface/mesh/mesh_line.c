/* SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_line.h"

#include "geometry/predicate.h"
#include "geometry/vec3.h"
#include "surface/mesh/mesh_facet.h"
#include "surface/tree/rounding.h"

#include <limits.h>
#include <math.h>

void cml_line_begin(struct cml_mesh_line *line, const struct cml_mesh_query *q, double t_max,
                    struct cml_line_parts *parts)
{
    *line = (struct cml_mesh_line){.q = q,
                                   .err_line = err_line_factor * q->err_query,
                                   .t = INFINITY,
                                   .primitive = -1,
                                   .entering_distance = INFINITY,
                                   .t_exit = INFINITY,
                                   .exit_distance = INFINITY,
                                   .exit_primitive = -1,
                                   .length = t_max,
                                   .parts = q->centred->mesh.unite ? parts : NULL};
    if (line->parts) {
        parts->pass = CML_LINE_COLLECTS;
        parts->count = parts->lot = parts->around = 0;
        parts->more = false;
    }
    cml_vec3_add_scaled(q->origin, q->err_query, q->direction, line->from);
}

/* On which side of an edge the line passes; from the lower index to the higher, so that the triangles of an
 * edge get opposite signs. */
static int side_of_edge(const struct cml_mesh_line *line, uint32_t i, uint32_t j)
{
    const double(*vertex)[3] = (const double(*)[3])line->q->centred->mesh.vertex;
    return i < j ? cml_line_side(vertex[i], vertex[j], line->from, line->q->direction)
                 : -cml_line_side(vertex[j], vertex[i], line->from, line->q->direction);
}

/* +1 when the line crosses the triangle upwards, -1 downwards, else 0. */
static int signed_crossing(const struct cml_mesh_line *line, const uint32_t v[3])
{
    const int side = side_of_edge(line, v[0], v[1]);
    return side_of_edge(line, v[1], v[2]) == side && side_of_edge(line, v[2], v[0]) == side ? side : 0;
}

static bool is_exiting(const struct cml_mesh_query *q, double along)
{
    return q->below ? along > 0 : along < 0;
}

/* cm; of the outer plane infinite where it has a hole. */
static double distance_from(const struct cml_mesh_line *line, int primitive, const double p[3])
{
    const struct cml_mesh_query *q = line->q;
    if (primitive != CML_OUTER_PLANE) return cml_facet_distance(q->centred, primitive, p);
    const bool is_hole = cml_query_border_side(q, p[0], p[1], line->err_line) == CML_INSIDE_BORDER;
    return is_hole ? INFINITY : fabs(q->centred->mesh.z_border - p[2]);
}

static double crossing_of(const struct cml_mesh_query *q, int primitive, double least)
{
    return cml_facet_crossing(q->centred, primitive, q->origin, q->direction, least);
}

/* A crossing ahead, at distance t. way: as of signed_crossing. */
static void keep_crossing(struct cml_mesh_line *line, int primitive, int way, double t)
{
    if (!is_exiting(line->q, way)) {
        line->entering_distance =
            fmin(line->entering_distance, distance_from(line, primitive, line->q->origin));
    } else if (t < line->t) {
        line->t = t;
        line->primitive = primitive;
    }
}

static void add_crossing(struct cml_mesh_line *line, int primitive, int way, double t)
{
    line->winding_ahead += way;
    keep_crossing(line, primitive, way, t);
}

/* ---- unions ---- */

enum { LOT = sizeof(((struct cml_line_parts *)0)->item) / sizeof(struct cml_line_crossing) };

/* Crossings that rounding has put at one place are told apart by number. */
static bool is_before(const struct cml_line_crossing *a, const struct cml_line_crossing *b)
{
    return a->t < b->t || (a->t == b->t && a->primitive < b->primitive);
}

/* Keeps the first of those that no lot has had. */
static void add_to_lot(struct cml_line_parts *parts, const struct cml_line_crossing *crossing)
{
    if (parts->lot == 0) parts->around += crossing->way;
    if (parts->lot > 0 && !is_before(&parts->last, crossing)) return;
    parts->more = parts->more || parts->count == LOT;
    if (parts->count == LOT && !is_before(crossing, &parts->item[LOT - 1])) return;
    int i = parts->count < LOT ? parts->count++ : LOT - 1;
    for (; i > 0 && is_before(crossing, &parts->item[i - 1]); i--) parts->item[i] = parts->item[i - 1];
    parts->item[i] = *crossing;
}

static void look_behind(struct cml_line_parts *parts, const struct cml_line_crossing *crossing)
{
    for (int i = 0; i < parts->count; i++)
        if (parts->item[i].part == crossing->part && is_before(&parts->item[i], crossing))
            parts->item[i].around += crossing->way;
}

/* How many parts less are around the line behind a crossing: none, where it is one of two of a part that have
 * been exchanged, so that there is no place between them. */
static int leaves_parts(const struct cml_line_crossing *crossing)
{
    return (crossing->around + crossing->way > 0) - (crossing->around > 0);
}

/* Whether a part begins where another one has ended, but for rounding. */
static bool closes_gap(const struct cml_mesh_line *line, const struct cml_line_crossing *out,
                       const struct cml_line_crossing *in)
{
    double place[3];
    cml_vec3_add_scaled(line->q->origin, out->t, line->q->direction, place);
    return leaves_parts(in) < 0 &&
           cml_facet_distance(line->q->centred, in->primitive, place) <= line->q->centred->err_mesh;
}

/* Where the number of parts falls to 0 or rises from there, up to the first exit. The last of a lot that has
 * others behind it belongs to the next: what follows a crossing must be known. */
static void follow_lot(struct cml_mesh_line *line)
{
    struct cml_line_parts *parts = line->parts;
    const int count = parts->more ? LOT - 1 : parts->count;
    parts->around_end = parts->around;
    for (int i = 0; i < count && line->primitive < 0; i++) {
        const struct cml_line_crossing *here = &parts->item[i];
        const bool inside = parts->around_end > 0;
        parts->around_end -= leaves_parts(here);
        int next = i + 1;
        while (next < parts->count && leaves_parts(&parts->item[next]) == 0) next++;
        if (inside && parts->around_end == 0 && next < parts->count &&
            closes_gap(line, here, &parts->item[next]))
            parts->around_end -= leaves_parts(&parts->item[i = next]);
        else if (inside != (parts->around_end > 0))
            keep_crossing(line, here->primitive, here->way, here->t);
        parts->last = parts->item[i];
    }
}

/* How many parts are around the place at distance t; many, where the lot does not tell. */
static int parts_around(const struct cml_line_parts *parts, double t)
{
    int around = parts->around;
    for (int i = 0; i < parts->count && parts->item[i].t <= t; i++) around -= leaves_parts(&parts->item[i]);
    return parts->more && t >= parts->item[LOT - 1].t ? INT_MAX : around;
}

bool cml_line_goes_on(struct cml_mesh_line *line)
{
    struct cml_line_parts *parts = line->parts;
    if (!parts) return false;
    if (parts->pass == CML_LINE_COLLECTS && parts->more) {
        parts->pass = CML_LINE_LOOKS_BEHIND;
        return true;
    }
    if (parts->pass == CML_LINE_COLLECTS)
        for (int i = 0; i < parts->count; i++) look_behind(parts, &parts->item[i]);
    if (parts->pass != CML_LINE_LOOKS_BESIDE) follow_lot(line);
    if (parts->pass != CML_LINE_LOOKS_BESIDE && parts->lot == 0) {
        line->winding_ahead = parts->around;
        parts->pass = CML_LINE_LOOKS_BESIDE;
        /* on its own side a packet that crosses something asks for nothing beside the line */
        return !(line->t < line->length) || (parts->around > 0) != (line->q->below != 0);
    }
    if (line->primitive >= 0 || !parts->more) return false;
    parts->pass = CML_LINE_COLLECTS;
    parts->lot++;
    parts->around = parts->around_end;
    parts->count = 0;
    parts->more = false;
    return true;
}

/* ---- what lies beside the line ---- */

/* A place of the line where it may pass an exiting facet: of those no further from their facet than rounding
 * can explain, the first is the exit. t + distance orders places so that a nearer facet wins over one that is
 * passed a little earlier, at the same corner. From a union no facet is an exit in another part; a packet
 * that comes to one has passed another facet before. */
static void add_exit_candidate(struct cml_mesh_line *line, int primitive, double t)
{
    double place[3];
    cml_vec3_add_scaled(line->q->origin, t, line->q->direction, place);
    const double distance = distance_from(line, primitive, place);
    if (!(distance <= line->err_line) || t + distance >= line->t_exit + line->exit_distance) return;
    if (line->parts && line->q->below && parts_around(line->parts, t) > 0) return;
    line->t_exit = t;
    line->exit_distance = distance;
    line->exit_primitive = primitive;
}

/* Distance along the line to the first corner, seen along it: the facet cannot be passed before. */
static double first_corner(const struct cml_mesh_query *q, int primitive)
{
    double first = INFINITY;
    for (int k = 0; k < 3; k++) {
        double to_corner[3];
        cml_vec3_subtract(cml_centred_corner(q->centred, primitive, k), q->origin, to_corner);
        first = fmin(first, cml_vec3_dot(to_corner, q->direction));
    }
    return first;
}

/* Where the line passes an exiting facet: it meets it, or is closest to it at an edge or at its beginning.
 * Its plane alone does not tell: between steep walls a line that begins beyond both meets their planes far
 * from where they end. */
static void add_exit(struct cml_mesh_line *line, int primitive, double t)
{
    const struct cml_mesh_query *q = line->q;
    if (first_corner(q, primitive) > line->t_exit + line->err_line) return;
    add_exit_candidate(line, primitive, 0);
    add_exit_candidate(line, primitive, fmax(0, t));
    for (int k = 0; k < 3; k++) {
        const double *a = cml_centred_corner(q->centred, primitive, k),
                     *b = cml_centred_corner(q->centred, primitive, (k + 1) % 3);
        add_exit_candidate(line, primitive, cml_facet_edge_approach(q->origin, q->direction, a, b));
    }
}

/* A packet that interacts near an edge may be beyond it, and leave where no line meets a facet: its next
 * query must know. height: of the facet's plane above the origin, along its normal. */
static void add_end(struct cml_mesh_line *line, int primitive, double height)
{
    const struct cml_mesh_query *q = line->q;
    const double left = height - line->length * cml_vec3_dot(q->direction, q->centred->plane[primitive]);
    double end[3];
    if (line->ends_near_facet || !(fabs(left) <= line->err_line)) return;
    cml_vec3_add_scaled(q->origin, line->length, q->direction, end);
    line->ends_near_facet = cml_facet_distance(q->centred, primitive, end) <= line->err_line;
}

/* ahead: the plane's side of from tells, exactly, where rounding of a distance could not. */
void cml_line_add(struct cml_mesh_line *line, int primitive)
{
    const struct cml_mesh_query *q = line->q;
    const struct cml_mesh *mesh = &q->centred->mesh;
    const uint32_t *v = mesh->triangle[primitive];
    const double *a = mesh->vertex[v[0]], *b = mesh->vertex[v[1]], *c = mesh->vertex[v[2]];
    const double *normal = q->centred->plane[primitive];
    double to_corner[3];
    cml_vec3_subtract(a, q->origin, to_corner);
    const double height = cml_vec3_dot(to_corner, normal);
    const int way = signed_crossing(line, v);
    const bool ahead = way != 0 && way * cml_plane_side(a, b, c, line->from) > 0,
               may_exit = is_exiting(q, cml_vec3_dot(q->direction, normal));
    const double t = ahead ? crossing_of(q, primitive, q->err_query) : 0;
    if (line->parts && line->parts->pass != CML_LINE_LOOKS_BESIDE) {
        const struct cml_line_crossing crossing = {t, primitive, (int)mesh->part[primitive], way, 0};
        if (ahead)
            (line->parts->pass == CML_LINE_COLLECTS ? add_to_lot : look_behind)(line->parts, &crossing);
        return;
    }
    line->winding += way;
    if (ahead && !line->parts) add_crossing(line, primitive, way, t);
    if (may_exit) add_exit(line, primitive, crossing_of(q, primitive, -INFINITY));
    add_end(line, primitive, height);
}

/* Whether the line still has the outer plane ahead, when it has been moved as cml_plane_side moves it. */
static bool outer_plane_is_ahead(const struct cml_mesh_line *line)
{
    const double height = line->q->centred->mesh.z_border - line->from[2], uz = line->q->direction[2];
    return height != 0 ? (height > 0) == (uz > 0) : uz < 0;
}

/* The outer plane is crossed where the sheet alone does not lead from one side to the other. A line that
 * grazes it may pass its border a little beyond it. */
static void add_outer_plane(struct cml_mesh_line *line)
{
    const struct cml_mesh_query *q = line->q;
    const double height = q->centred->mesh.z_border - q->origin[2], uz = q->direction[2];
    const double t = height / uz, later = t + line->err_line / (2 * fabs(uz));
    const int way = uz < 0 ? 1 : -1;
    if (uz == 0 || q->centred->mesh.closed) return;
    if (line->winding != way && outer_plane_is_ahead(line))
        add_crossing(line, CML_OUTER_PLANE, way, fmax(t, q->err_query));
    if (!is_exiting(q, way)) return;
    add_exit_candidate(line, CML_OUTER_PLANE, fmax(0, t));
    add_exit_candidate(line, CML_OUTER_PLANE, fmax(0, later));
}

/* Whether the packet's position, or what is just ahead of it, lies below the boundary: at its far end the
 * line is below when it goes down, but of a closed mesh outside, and from there back every crossing ahead
 * changes sides. */
static bool lies_below(const struct cml_mesh_line *line)
{
    const double uz = line->q->direction[2];
    if (line->q->centred->mesh.closed) return line->winding_ahead > 0;
    const bool ends_below = uz != 0 ? uz > 0 : line->q->origin[2] >= line->q->centred->mesh.z_border;
    return ends_below + line->winding_ahead > 0;
}

/* Where the packet is on its own side, the first exiting crossing ahead counts. Where it is beyond by
 * rounding and no facet that it is about to come back through is near, the facet that it passes does. What
 * the query had found at the same place stays: it may have the normal of an edge or a vertex. */
void cml_line_decide(struct cml_mesh_line *line, struct cml_mesh_query *q)
{
    const double t_max = line->length;
    add_outer_plane(line);
    if (lies_below(line) != (q->below != 0) && line->entering_distance > line->err_line &&
        line->exit_primitive >= 0) {
        line->t = line->t_exit;
        line->primitive = line->exit_primitive;
    }
    const bool same_place = q->primitive >= 0 && fabs(fmax(q->t, 0) - line->t) <= q->err_query;
    if (line->primitive >= 0 && line->t < t_max && same_place) return;
    q->t = t_max;
    q->primitive = -1;
    if (line->primitive >= 0 && line->t < t_max) cml_query_set_hit(q, line->primitive, line->t);
}
