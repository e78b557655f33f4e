/* The whole line of a query against the whole boundary, with the signs of exact arithmetic: what is crossed
 * in doubtful cases, near edges and vertices, where rounding has a say in which facets a ray meets and on
 * which side of them a packet stands.
 *
 * A line through a sheet that divides space crosses it alternately up and down. Signs are those of simulation
 * of simplicity [Edelsbrunner and Muecke, ACM Transactions on Graphics 9 (1), 1990; geometry/predicate.h]:
 * all belong to one line, moved by less than any number, that meets no edge and no vertex. So that
 * alternation holds for what is computed too, and the winding number of the crossings ahead (upwards less
 * downwards) tells on which side the packet lies. Not its rounded position, but the point of its line that is
 * ahead of it by rounding: a packet that crosses a facet nearer than that may find itself before it again.
 *
 * Of a union (geometry/mesh.h) the winding number is that of the parts around a place, and only where it
 * falls to 0 or rises from there is a boundary. So crossings are put in order, as many at a time as there is
 * room for: the line is followed for them, then for what lies beside it, and once more for each further lot.
 * A gap that the rounding of the mesh could close is none: faces of parts may touch.
 *
 * Where that is not the packet's side, it stands beyond a facet by rounding. Either it comes back through
 * that facet, which is no crossing, or it heads out: through the first facet that its line passes at no more
 * than rounding. SPDX-License-Identifier: MIT */
#pragma once

#include "surface/mesh/mesh_query.h"

/* A crossing ahead. way: +1 upwards, -1 downwards. around: how often its part is around the line behind it,
 * by the crossings that are put behind it: 0 or 1, unless rounding has exchanged it with another of its part.
 */
struct cml_line_crossing {
    double t;
    int primitive, part, way, around;
};

/* The crossings ahead of a line through parts that unite, in their order. */
struct cml_line_parts {
    struct cml_line_crossing item[64]; /* a lot of them */
    int count, lot;                    /* how many, and which lot, from 0 */
    int around, around_end; /* parts around the places where the lot begins, and where it was followed to */
    bool more;              /* there are others behind the lot */
    enum { CML_LINE_COLLECTS, CML_LINE_LOOKS_BEHIND, CML_LINE_LOOKS_BESIDE } pass;
    struct cml_line_crossing last; /* that was followed */
};

/* Distances along the line from q's origin, cm. Facets are "exiting" and "entering" as in mesh_query.h. */
struct cml_mesh_line {
    const struct cml_mesh_query *q; /* borrowed */
    double err_line; /* cm; what rounding can put between a packet and the facet it stands on */
    double from[3];  /* centred frame: the point of the line ahead of the packet by rounding: what is ahead is
                      * so  from here */
    int winding, winding_ahead; /* facets crossed upwards less downwards: by the whole line, ahead */
    double t;                   /* distance of the first exiting crossing ahead */
    int primitive;              /* its facet; -1: none */
    double entering_distance;   /* cm from the origin to the closest facet with an entering crossing ahead */
    double t_exit;              /* where the line first passes an exiting facet at no more than err_line */
    double exit_distance;       /* cm between them there */
    int exit_primitive;         /* that facet; -1: none is near the line */
    double length;              /* of the path, cm */
    bool ends_near_facet;       /* it ends within err_line of a facet */
    struct cml_line_parts *parts; /* of a union, else NULL */
};

/* Borrows q, which has gone through cml_query_begin, and *parts, which a union needs. t_max: length of the
 * path, cm. */
void cml_line_begin(struct cml_mesh_line *line, const struct cml_mesh_query *q, double t_max,
                    struct cml_line_parts *parts);

/* Takes in a triangle. All must be offered, each once, that the line meets or that lie near the packet. */
void cml_line_add(struct cml_mesh_line *line, int primitive);

/* After that: whether all must be offered once more. */
bool cml_line_goes_on(struct cml_mesh_line *line);

/* What the packet crosses before its path ends: makes it q's best, or leaves q's if that is the same place.
 */
void cml_line_decide(struct cml_mesh_line *line, struct cml_mesh_query *q);
