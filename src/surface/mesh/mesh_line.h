/* The whole line of a query against the whole boundary, with the signs of exact arithmetic: what is crossed
 * in doubtful cases, beside edges and vertices, where rounding has a say in which facets a ray meets and on
 * which side of them a packet stands.
 * A line through a sheet that divides space crosses it alternately up and down. Where every sign is that of
 * the same line, moved by less than any number, that holds for what is computed too: so the crossings ahead
 * tell on which side the packet lies: not its rounded position, but the point of its line that is ahead of it
 * by rounding, for a packet that crosses a facet nearer than that may find itself before it again. Where that
 * is not the packet's side, it stands beyond a facet by rounding. Either it comes back through that facet,
 * which is no crossing, or it heads out: through the first facet that its line passes by no more than
 * rounding. SPDX-License-Identifier: MIT */
#ifndef CML_MESH_LINE_H
#define CML_MESH_LINE_H

#include "surface/mesh/mesh_query.h"

struct cml_mesh_line {
    const struct cml_mesh_query *q; /* borrowed */
    double near;    /* cm; what rounding can put between a packet and the facet it stands on */
    double from[3]; /* the point of the line ahead of the packet by rounding: what is ahead is so from here */
    int winding, winding_ahead; /* facets crossed upwards less downwards: by the line, ahead */
    double t;                   /* distance of the first one ahead that leads away from the packet's side */
    int primitive;              /* that facet; -1: none */
    double back; /* distance from the closest facet ahead that leads back to the packet's side */
    double exit_t,
        beside;       /* where the line first passes beside a facet that leads away, and how far beside */
    int exit;         /* that facet; -1: none is near the line */
    double length;    /* of the path */
    bool ends_beside; /* it ends within rounding of a facet */
};

/* Borrows q, which has gone through cml_query_begin. t_max: where the path ends. */
void cml_line_begin(struct cml_mesh_line *line, const struct cml_mesh_query *q, double t_max);

/* Counts a triangle. All must be offered, each once, that the line meets or that lie near the packet. */
void cml_line_add(struct cml_mesh_line *line, int primitive);

/* What the packet crosses before its path ends: makes it q's best, or leaves q's if that is the same place.
 */
void cml_line_decide(struct cml_mesh_line *line, struct cml_mesh_query *q);

#endif
