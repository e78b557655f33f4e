/* Decides doubtful queries by all crossings of the query's line with the mesh. SPDX-License-Identifier:
 * MIT */
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

/* Returns the side of an edge on which the line passes. The edge is taken from the lower vertex number to the
 * higher one, so that the triangles of an edge get opposite signs. */
static int side_of_edge(const struct cml_mesh_line *line, uint32_t i, uint32_t j)
{
    const double(*vertex)[3] = (const double(*)[3])line->q->centred->mesh.vertex;
    return i < j ? cml_line_side(vertex[i], vertex[j], line->from, line->q->direction)
                 : -cml_line_side(vertex[j], vertex[i], line->from, line->q->direction);
}

/* Returns +1 if the line crosses the triangle upwards, -1 if downwards, 0 if it does not cross it. */
static int signed_crossing(const struct cml_mesh_line *line, const uint32_t v[3])
{
    const int side = side_of_edge(line, v[0], v[1]);
    return side_of_edge(line, v[1], v[2]) == side && side_of_edge(line, v[2], v[0]) == side ? side : 0;
}

/* True if a crossing leaves the packet's side of the boundary. along: positive for a crossing upwards. */
static bool is_exiting(const struct cml_mesh_query *q, double along)
{
    return q->below ? along > 0 : along < 0;
}

/* Returns the distance of p from a primitive, cm; infinite from the outer plane if p is over its hole. */
static double distance_from(const struct cml_mesh_line *line, int primitive, const double p[3])
{
    const struct cml_mesh_query *q = line->q;
    if (primitive != CML_OUTER_PLANE) return cml_facet_distance(q->centred, primitive, p);
    const bool is_hole = cml_query_border_side(q, p[0], p[1], line->err_line) == CML_INSIDE_BORDER;
    return is_hole ? INFINITY : fabs(q->centred->mesh.z_border - p[2]);
}

/* Returns the distance along the line to its crossing with a facet; `least` as for cml_facet_crossing. */
static double crossing_of(const struct cml_mesh_query *q, int primitive, double least)
{
    return cml_facet_crossing(q->centred, primitive, q->origin, q->direction, least);
}

/* Keeps a crossing ahead at distance t if it is the first exiting one, or the closest entering one. way: +1
 * upwards, -1 downwards. */
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

/* Adds a crossing ahead to the winding number. Keeps the crossing if it is the first exiting or the closest
 * entering one. */
static void add_crossing(struct cml_mesh_line *line, int primitive, int way, double t)
{
    line->winding_ahead += way;
    keep_crossing(line, primitive, way, t);
}

/* ---- unions of parts ---- */

enum { LOT = sizeof(((struct cml_line_parts *)0)->item) / sizeof(struct cml_line_crossing) };

/* True if crossing a comes before crossing b. Crossings that rounding has put at one place are ordered by
 * facet number. */
static bool is_before(const struct cml_line_crossing *a, const struct cml_line_crossing *b)
{
    return a->t < b->t || (a->t == b->t && a->primitive < b->primitive);
}

/* Adds a crossing of the line to the lot, the list of the first crossings that were in no earlier lot. */
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

/* Adds the direction of a crossing to `around` of all crossings of its part that lie before it in the lot. */
static void look_behind(struct cml_line_parts *parts, const struct cml_line_crossing *crossing)
{
    for (int i = 0; i < parts->count; i++)
        if (parts->item[i].part == crossing->part && is_before(&parts->item[i], crossing))
            parts->item[i].around += crossing->way;
}

/* Returns 1 if the line leaves a part at the crossing, -1 if it enters one, else 0. It is 0 for two crossings
 * of one part whose order rounding has exchanged, since there is no place between them. */
static int leaves_parts(const struct cml_line_crossing *crossing)
{
    return (crossing->around + crossing->way > 0) - (crossing->around > 0);
}

/* True if, except for rounding, a part begins where another part has ended. */
static bool closes_gap(const struct cml_mesh_line *line, const struct cml_line_crossing *out,
                       const struct cml_line_crossing *in)
{
    double place[3];
    cml_vec3_add_scaled(line->q->origin, out->t, line->q->direction, place);
    return leaves_parts(in) < 0 &&
           cml_facet_distance(line->q->centred, in->primitive, place) <= line->q->centred->err_mesh;
}

/* Follows the crossings of a line with a union of bodies, a lot at a time, and keeps those where the line
 * comes out of all parts or enters the first one. Deciding a crossing needs the next one, so a lot's last
 * crossing is left to the next lot if more follow. */
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

/* Returns the number of parts around the place at distance t; INT_MAX behind the lot, where the number is
 * unknown. */
static int parts_around(const struct cml_line_parts *parts, double t)
{
    int around = parts->around;
    for (int i = 0; i < parts->count && parts->item[i].t <= t; i++) around -= leaves_parts(&parts->item[i]);
    return parts->more && t >= parts->item[LOT - 1].t ? INT_MAX : around;
}

/* A union of bodies takes several passes: to collect crossings, to look for crossings behind them, and to
 * look for facets beside the line. Other meshes take one. */
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
        /* a packet on its own side with a crossing ahead needs no facets beside the line */
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

/* ---- facets beside the line ---- */

/* Considers the place at distance t as the exit through a facet. Among places no further from their facet
 * than rounding explains, the first is the exit. Places are ordered by t + distance, so that a nearer facet
 * wins over one that the line passes a little earlier at the same corner. In a union, a place inside another
 * part is no exit: a packet that comes to it has passed another facet before. */
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

/* Returns the distance along the line to the facet's first corner, as seen along the line: the line cannot
 * pass the facet before. */
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

/* Considers the places where the line may pass an exiting facet: the crossing, the places closest to its
 * edges, and the line's beginning. The facet's plane alone does not tell. A line that begins beyond two steep
 * walls meets their planes far from where the walls end. */
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

/* Sets line->ends_near_facet if the path ends close to this facet. A packet that interacts near an edge may
 * be beyond the edge, and leave where no line meets a facet; its next query must therefore know. height:
 * height of the facet's plane above the origin, along the facet's normal. */
static void add_end(struct cml_mesh_line *line, int primitive, double height)
{
    const struct cml_mesh_query *q = line->q;
    const double left = height - line->length * cml_vec3_dot(q->direction, q->centred->plane[primitive]);
    double end[3];
    if (line->ends_near_facet || !(fabs(left) <= line->err_line)) return;
    cml_vec3_add_scaled(q->origin, line->length, q->direction, end);
    line->ends_near_facet = cml_facet_distance(q->centred, primitive, end) <= line->err_line;
}

/* The exact side of the facet's plane on which the line begins tells if the crossing is ahead; a rounded
 * distance could not tell. */
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

/* True if the line crosses the outer plane ahead of its beginning. A beginning that lies in the plane counts
 * as moved by an infinitely small amount, as in cml_plane_side. */
static bool outer_plane_is_ahead(const struct cml_mesh_line *line)
{
    const double height = line->q->centred->mesh.z_border - line->from[2], uz = line->q->direction[2];
    return height != 0 ? (height > 0) == (uz > 0) : uz < 0;
}

/* Adds a crossing of the outer plane if the crossings of the sheet alone do not lead from one side to the
 * other. If the line goes towards the other side, also tests whether it exits through the plane: at the
 * crossing and a little behind it, because a line at a small angle to the plane may pass the plane's border
 * there. */
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

/* True if the packet's position, or the place just ahead of it, lies below the boundary. At its far end, a
 * line that goes down is below a sheet, and any line is outside of a closed mesh. From there back, every
 * crossing ahead changes sides. */
static bool lies_below(const struct cml_mesh_line *line)
{
    const double uz = line->q->direction[2];
    if (line->q->centred->mesh.closed) return line->winding_ahead > 0;
    const bool ends_below = uz != 0 ? uz > 0 : line->q->origin[2] >= line->q->centred->mesh.z_border;
    return ends_below + line->winding_ahead > 0;
}

/* If the packet is on its own side, the first crossing ahead that leaves counts; if rounding has put it
 * beyond a facet, this facet counts, unless it is about to come back. A crossing that the query found at the
 * same place is kept, because it may have the normal of an edge. */
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
