/* Decides doubtful queries near edges and vertices, where rounding affects which facets a ray meets and on
 * which side of a facet a packet stands. The whole line of the query is tested against the whole boundary,
 * with exact signs.
 *
 *     line   ---o-------/-------\------/---->     crossings ahead: up, down, up; their winding
 *            packet    up      down   up          number, up minus down, tells the packet's side
 *
 * A line through a sheet that divides space crosses it alternately up and down. The signs are those of
 * simulation of simplicity [Edelsbrunner and Muecke, ACM Transactions on Graphics 9 (1), 1990;
 * geometry/predicate.h]. All of them belong to one line, moved by less than any number, that meets no edge
 * and no vertex. The alternation therefore holds for the computed signs, too. The winding number tells the
 * side of the line's point that lies ahead of the packet by rounding. The packet's rounded position is not
 * used, because a packet that crosses a nearer facet could find itself before the facet again.
 *
 * In a union (mesh->unite, geometry/mesh.h) the winding number counts the parts around a place. The boundary
 * is only where it falls to 0 or rises from 0. Therefore crossings must be followed in order, a lot of
 * limited size at a time: one pass over the triangles collects a lot, a second one finds the facets beside
 * the line, and each further lot needs another pass. A gap that the rounding of the mesh could close is
 * ignored, so that faces of parts may touch.
 *
 * If the winding number contradicts the packet's side, the packet stands beyond a facet by rounding. Either
 * it comes back through that facet, which is no crossing, or it leaves: through the first facet that its line
 * passes within rounding.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/mesh/mesh_query.h"

/* A crossing ahead. way: +1 upwards, -1 downwards. around: how many times the crossing's part surrounds the
 * line behind the crossing, counted from the crossings sorted behind it: 0 or 1, unless rounding has
 * exchanged two crossings of the part. */
struct cml_line_crossing {
    double t;
    int primitive, part, way, around;
};

/* The crossings ahead of a line through parts that unite, in order. */
struct cml_line_parts {
    struct cml_line_crossing item[64]; /* the crossings of the current lot, in order */
    int count, lot;                    /* crossings in the lot; number of the lot, from 0 */
    int around, around_end; /* number of parts around the line where the lot begins, and where following it
                               ended */
    bool more;              /* more crossings lie behind the lot */
    enum { CML_LINE_COLLECTS, CML_LINE_LOOKS_BEHIND, CML_LINE_LOOKS_BESIDE } pass;
    struct cml_line_crossing last; /* last crossing that was followed */
};

/* The state of a line. Distances along the line count from q's origin, cm. Facets are "exiting" or "entering"
 * as in mesh_query.h. */
struct cml_mesh_line {
    const struct cml_mesh_query *q; /* the query, borrowed */
    double err_line; /* largest distance by which rounding can separate a packet from the facet it stands
                        on, cm */
    double from[3];  /* point of the line ahead of the packet by rounding, centred frame; crossings beyond
                        it count as ahead */
    int winding, winding_ahead; /* facets crossed upwards minus downwards, by the whole line and ahead */
    double t;                   /* distance of the first exiting crossing ahead */
    int primitive;              /* facet of the first exiting crossing; -1: none */
    double entering_distance;   /* distance from the origin to the closest facet with an entering crossing
                                   ahead, cm */
    double t_exit;              /* where the line first passes an exiting facet within err_line */
    double exit_distance;       /* distance between the line and this facet at t_exit, cm */
    int exit_primitive;   /* the exiting facet that t_exit and exit_distance describe; -1: the line comes near
                             no exiting facet */
    double length;        /* length of the path, cm */
    bool ends_near_facet; /* the path ends within err_line of a facet */
    struct cml_line_parts *parts; /* ordered crossings of a union's parts; NULL for other meshes */
};

/* Begins a line. Borrows q, which cml_query_begin has prepared, and *parts, which only a union uses. t_max:
 * length of the path, cm. */
void cml_line_begin(struct cml_mesh_line *line, const struct cml_mesh_query *q, double t_max,
                    struct cml_line_parts *parts);

/* Adds a triangle to the data of a line. Each triangle that the line meets or that lies near the packet must
 * be added once per pass. */
void cml_line_add(struct cml_mesh_line *line, int primitive);

/* Ends a pass over the triangles. Returns true if all triangles must be added once more. */
bool cml_line_goes_on(struct cml_mesh_line *line);

/* Decides which crossing the packet of q meets before its path ends, and makes that crossing q's best. Leaves
 * q unchanged if its best crossing already lies at the decided place. */
void cml_line_decide(struct cml_mesh_line *line, struct cml_mesh_query *q);
