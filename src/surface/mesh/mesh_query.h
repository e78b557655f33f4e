/* The double-precision half of a mesh query: one ray against triangles that somebody else has found, and
 * against the outer plane. Triangles are tested by the signs of Pluecker products, which neighbours compute
 * alike from their shared edge, so that no ray passes between them. Knows no tree and no Embree; see
 * mesh_surface.h. SPDX-License-Identifier: MIT */
#ifndef CML_MESH_QUERY_H
#define CML_MESH_QUERY_H

#include "surface/mesh/mesh_body.h"
#include "mesh_crossing.h"

/* A ray on its way to its first crossing. */
struct cml_mesh_query {
    const struct cml_mesh_body *body;
    double origin[3], direction[3]; /* relative to centre */
    double base;                    /* distance at which the ray enters the mesh's box */
    double near[3]; /* that point: triangles are tested from there, so that a far origin costs no digits */
    double blur;    /* rounding of its coordinates */
    double coarse;  /* more than rounding can make of any edge product */
    double slack;   /* the rounding of the packet's position: how far behind the origin a crossing may lie */
    double reach;   /* how far rounding in all can put a crossing from where it is */
    double least;   /* -slack, or where the line crosses `exclude` when the packet came straight through it */
    double lenience; /* how many times that, for facets that the ray grazes */
    double touch;    /* a packet this close to a facet's plane may be beyond it; -1 when it stands on one */
    int below, exclude;
    double t;         /* best so far */
    double weight[3]; /* its barycentric weights */
    double seam[3];   /* sum of unit facet normals when the best lies on an edge, else the facet's */
    int primitive;    /* -1: none */
    bool on_seam;
    bool on_edge; /* the packet stands close to an edge: rounding may have put it beyond facets beside it */
    bool doubt;   /* the border was passed so closely that rounding decided what is crossed, or the fast way
                   * has missed a facet */
    double back;  /* the fast way's: where it met a facet that leads back to the packet's side */
    /* Edges that the best crossing is on, but for rounding, those that two of its facets share left out; 0
     * when no other is: then those facets are all there are at its place, and it is a crossing whatever
     * rounding does. Sums of random numbers of the edges' ends; of the candidate last tested and of the best.
     */
    uint64_t candidate_open, open;
};

/* Arguments as of cml_mesh_surface_hit (kernels/mesh_crossing.h). */
void cml_query_begin(struct cml_mesh_query *q, const struct cml_mesh_body *body, const double p[3],
                     const double u[3], int below, double t_max, int exclude, int straight, double slack);

/* Makes the point where the ray enters the box, or `back` before it, the near point: only numbers of the
 * mesh's own size are ever rounded to float. *leave: where it leaves the box, at most q->t. False when it
 * never enters. */
bool cml_query_approach(struct cml_mesh_query *q, double back, double *leave);

/* The same for the whole line, ahead and behind: the near point is where it enters the box. */
bool cml_query_approach_all(struct cml_mesh_query *q, double *leave);

/* Whether a triangle is crossed away from the packet's side: without gaps between neighbours. *t and
 * barycentric weights. Needs cml_query_approach. */
bool cml_query_cross(struct cml_mesh_query *q, int primitive, double *t, double weight[3]);

/* Makes a crossing the best so far if it is; one at the same place on a shared edge adds its facet to the
 * seam. */
void cml_query_take(struct cml_mesh_query *q, int primitive, double t, const double weight[3]);

/* Distance to the plane of a facet; *along is the product of direction and upward unit normal. */
double cml_query_facet_distance(const struct cml_mesh_query *q, int primitive, double *along);

/* Sets q->doubt where a packet that stands on no facet lies within rounding of this one's plane. */
void cml_query_feel(struct cml_mesh_query *q, int primitive);

/* As cml_query_take for a crossing that lies clearly inside its triangle, whose unit normal (up) the caller
 * has. */
void cml_query_take_inside(struct cml_mesh_query *q, int primitive, const double normal[3], double t,
                           const double weight[3]);

/* Makes a primitive the best, at distance t, whatever was the best before. */
void cml_query_take_settled(struct cml_mesh_query *q, int primitive, double t);

/* Where a place lies to the mesh's border: within a distance d of it, or else outside or inside. */
enum cml_border_side { CML_OUTSIDE_BORDER, CML_AT_BORDER, CML_INSIDE_BORDER };
enum cml_border_side cml_query_border_side(const struct cml_mesh_query *q, double x, double y, double d);

/* Lets the plane outside the footprint compete; sets q->doubt close to the border. */
void cml_query_outer_plane(struct cml_mesh_query *q);

/* Whether a crossing at distance t is not behind the packet; along: product of direction and unit normal. */
bool cml_query_is_ahead(const struct cml_mesh_query *q, double t, double along);

/* Whether rounding had a say in the best crossing, or in there being none: cml_line_decide has to tell. */
bool cml_query_is_doubtful(const struct cml_mesh_query *q);

/* Whether only the exact test can tell that the ray meets no triangle: it passes the border, before its end,
 * closely, or it ends where no packet of its side can be, beyond all triangles. */
bool cml_query_may_have_missed(const struct cml_mesh_query *q);

/* 1 and the crossing, with its normals, if there is one. */
int cml_query_finish(const struct cml_mesh_query *q, const double p[3], const double u[3],
                     struct cml_mesh_crossing *crossing);

#endif
