/* The double-precision half of a mesh query: one ray against triangles that somebody else has found, and
 * against the outer plane. Knows no tree and no Embree; see mesh_surface.h.
 *
 * A triangle is tested by the signs of three edge products, which are permuted inner products of the Pluecker
 * coordinates of ray and edge [Platis and Theoharis, Fast ray-tetrahedron intersection using Pluecker
 * coordinates, Journal of Graphics Tools 8 (4), 2003; DAGMC uses the same test]. Both triangles of an edge
 * compute it from the same end, so they get opposite numbers and no ray passes between them: the test is
 * watertight [as Woop, Benthin and Wald, Journal of Computer Graphics Techniques 2 (1), 2013]. Where a
 * product may be 0 but for rounding, both triangles are hit, and the query says that it is in doubt;
 * cml_line_decide (mesh_line.h) then decides by exact arithmetic.
 *
 * A packet knows on which side of the boundary it is. Only crossings that leave that side ("exiting", as in
 * DAGMC) are looked for; one that comes back to it ("entering") can only follow an exiting one.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/tree/centred_mesh.h"
#include "mesh_crossing.h"

/* A ray on its way to its first crossing. Places in the centred frame (centred_mesh.h), lengths and distances
 * along the ray in cm. The bounds err_ are those of rounding.h. */
struct cml_mesh_query {
    const struct cml_centred_mesh *centred; /* borrowed */
    double origin[3], direction[3];         /* direction: unit */
    double entry[3]; /* where the ray enters the mesh's box: triangles are tested from here, so that a far
                      * origin costs no digits */
    double t_entry;  /* its distance */
    double err_entry, err_product, err_position, err_query;
    double t_min; /* the least distance of a crossing: -err_position, or where the ray crosses `exclude` if
                   * the packet came undeflected through it */
    double grazing_factor; /* times t_min: the same for facets that the ray grazes */
    double
        contact_distance; /* a packet this close to a facet's plane may be beyond it; -1: it stands on one */
    int below;            /* the packet is below the boundary */
    int exclude;          /* the primitive that it stands on, -1, CML_NEAR_FACETS or CML_OFF_FACETS */
    double t;             /* distance of the best crossing so far, at first the length of the path */
    double weight[3];     /* its barycentric weights */
    double normal_sum[3]; /* sum of unit facet normals when the best lies on an edge, else the facet's */
    int primitive;        /* -1: none */
    bool hits_edge;       /* the best lies on an edge or a vertex: other facets may have it too */
    bool starts_on_edge; /* the packet stands close to an edge: rounding may have put it beyond the next facet
                          */
    bool in_doubt;       /* rounding decides what is crossed, or the packet comes from the wrong side */
    uint64_t candidate_open_edges,
        open_edges; /* of the triangle last tested, of the best; see random_number */
};

/* Arguments as of cml_mesh_surface_hit (kernels/mesh_crossing.h). */
void cml_query_begin(struct cml_mesh_query *q, const struct cml_centred_mesh *centred, const double p[3],
                     const double u[3], int below, double t_max, int exclude, int undeflected,
                     double err_position);

/* Clips the ray to the mesh's box and puts the entry point there: only numbers of the mesh's own size are
 * ever rounded to float. *leave: where the ray leaves the box, at most q->t. False when it never enters. */
bool cml_query_clip_ray(struct cml_mesh_query *q, double *leave);

/* Puts the entry point where the ray enters the mesh's box, or at the origin close to it, and no more: for
 * single precision. False when it never enters. */
bool cml_query_enter(struct cml_mesh_query *q);

/* cml_query_clip_ray for the whole line, ahead and behind. */
bool cml_query_clip_line(struct cml_mesh_query *q, double *leave);

/* Whether the ray exits through a triangle, at *t, and with which barycentric weights. Needs
 * cml_query_clip_ray. Neighbours leave no gap. */
bool cml_query_intersect(struct cml_mesh_query *q, int primitive, double *t, double weight[3]);

/* Makes a crossing the best so far if it is; one at the same place on a shared edge adds its facet's normal.
 */
void cml_query_add_hit(struct cml_mesh_query *q, int primitive, double t, const double weight[3]);

/* As cml_query_add_hit for a crossing well inside its triangle, whose unit normal (up) the caller has. */
void cml_query_add_inner_hit(struct cml_mesh_query *q, int primitive, const double normal[3], double t,
                             const double weight[3]);

/* Makes a primitive the best, at distance t, whatever was the best before. */
void cml_query_set_hit(struct cml_mesh_query *q, int primitive, double t);

/* Distance along the ray to the plane of a facet. */
double cml_query_plane_distance(const struct cml_mesh_query *q, int primitive);

/* Sets q->in_doubt where the origin is within q->contact_distance of this facet's plane. */
void cml_query_test_contact(struct cml_mesh_query *q, int primitive);

/* Where a place lies to the mesh's border: within a distance d of it, or else outside or inside. */
enum cml_border_side { CML_OUTSIDE_BORDER, CML_AT_BORDER, CML_INSIDE_BORDER };
enum cml_border_side cml_query_border_side(const struct cml_mesh_query *q, double x, double y, double d);

/* Lets the outer plane compete; sets q->in_doubt close to the border. */
void cml_query_intersect_outer_plane(struct cml_mesh_query *q);

/* Whether rounding had a say in the best crossing, or in there being none: cml_line_decide has to tell. Of a
 * union also where another part may be around the crossing, or pass the place where the packet stands. */
bool cml_query_is_doubtful(const struct cml_mesh_query *q);

/* 1 and the crossing, with its normals, if there is one. p, u: as given to cml_query_begin. */
int cml_query_finish(const struct cml_mesh_query *q, const double p[3], const double u[3],
                     struct cml_mesh_crossing *crossing);
