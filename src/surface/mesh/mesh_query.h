/* The double-precision part of a mesh query: one ray against triangles that a search has found, and against
 * the outer plane. Knows no tree and no Embree; see mesh_surface.h.
 *
 * A triangle is tested by the signs of three edge products, which are permuted inner products of the Pluecker
 * coordinates of ray and edge [Platis and Theoharis, Fast ray-tetrahedron intersection using Pluecker
 * coordinates, Journal of Graphics Tools 8 (4), 2003; DAGMC uses the same test]. The two triangles of an edge
 * compute its product from the same end. They get opposite numbers, so that no ray passes between them: the
 * test is watertight [as Woop, Benthin and Wald, Journal of Computer Graphics Techniques 2 (1), 2013]. If
 * rounding could make a product 0, both triangles are hit, and the query is in doubt; cml_line_decide
 * (mesh_line.h) then decides by exact arithmetic.
 *
 * A packet knows on which side of the boundary it is. The query looks only for crossings that leave that side
 * ("exiting", as in DAGMC). A crossing that comes back ("entering") can only follow an exiting one.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/tree/centred_mesh.h"
#include "mesh_crossing.h"

/* A ray during the search for its first crossing. Places are in the centred frame (centred_mesh.h), lengths
 * and distances along the ray in cm. rounding.h explains the bounds err_. */
struct cml_mesh_query {
    const struct cml_centred_mesh *centred; /* the mesh, borrowed */
    double origin[3], direction[3];         /* position and unit direction of the ray */
    double entry[3]; /* where the ray enters the mesh's box: triangles are tested from here, so that a
                        distant origin costs no digits */
    double t_entry;  /* distance of the entry point */
    double err_entry, err_product, err_position, err_query;
    double t_min; /* smallest distance of a crossing: -err_position, or where the ray crosses `exclude` if
                     the packet came undeflected through it */
    double grazing_factor;   /* times t_min: smallest distance of a crossing with a facet at a small angle */
    double contact_distance; /* a packet this close to a facet's plane may be beyond it; -1: the packet stands
                                on a facet */
    int below;               /* the packet is below the boundary */
    int exclude;             /* the primitive on which the packet stands, or -1, CML_NEAR_FACETS or
                                CML_OFF_FACETS */
    double t;                /* distance of the best crossing so far; at first the length of the path */
    double weight[3];        /* barycentric weights of the best crossing */
    double normal_sum[3]; /* facet normal of the best crossing; sum of facet normals if it lies on an edge */
    int primitive;        /* facet of the best crossing; -1: none */
    bool hits_edge;       /* the best crossing lies on an edge or a vertex, which other facets may share */
    bool starts_on_edge;  /* the packet stands close to an edge: rounding may have put it beyond the next
                             facet */
    bool in_doubt;        /* rounding decides the crossing, or the packet comes from the wrong side */
    uint64_t candidate_open_edges,
        open_edges; /* sums over edges that the line passes closely, of the last tested triangle and of the
                       best crossing; 0 if the facets met leave no gap; see random_number */
};

/* Begins a query. The arguments are those of cml_mesh_surface_hit (kernels/mesh_crossing.h). */
void cml_query_begin(struct cml_mesh_query *q, const struct cml_centred_mesh *centred, const double p[3],
                     const double u[3], int below, double t_max, int exclude, int undeflected,
                     double err_position);

/* Clips the ray to the mesh's box and moves the entry point there, so that only numbers of the mesh's size
 * are rounded to float. *leave: where the ray leaves the box, at most q->t. Returns false if the ray never
 * enters the box. */
bool cml_query_clip_ray(struct cml_mesh_query *q, double *leave);

/* Sets only the entry point, for a search in single precision: where the ray enters the mesh's box, or the
 * origin if that is close. Returns false if the ray never enters the box. */
bool cml_query_enter(struct cml_mesh_query *q);

/* Clips the whole line, ahead and behind, as cml_query_clip_ray clips a ray. */
bool cml_query_clip_line(struct cml_mesh_query *q, double *leave);

/* Returns true if the ray exits through a triangle; sets its distance *t and barycentric weights. Needs
 * cml_query_clip_ray. Neighbouring triangles leave no gap. */
bool cml_query_intersect(struct cml_mesh_query *q, int primitive, double *t, double weight[3]);

/* Keeps a crossing if it is the best so far. A crossing at the same place on a shared edge adds its facet's
 * normal. */
void cml_query_add_hit(struct cml_mesh_query *q, int primitive, double t, const double weight[3]);

/* Makes a crossing well inside its triangle the best if it is nearer than the best so far. Such a crossing
 * touches no edge. normal: the triangle's unit normal, upwards. */
void cml_query_add_inner_hit(struct cml_mesh_query *q, int primitive, const double normal[3], double t,
                             const double weight[3]);

/* Makes the crossing with a primitive at distance t the best, whatever was the best before. */
void cml_query_set_hit(struct cml_mesh_query *q, int primitive, double t);

/* Returns the distance along the ray to the plane of a facet. */
double cml_query_plane_distance(const struct cml_mesh_query *q, int primitive);

/* Sets q->in_doubt if the origin is within q->contact_distance of this facet's plane. */
void cml_query_test_contact(struct cml_mesh_query *q, int primitive);

/* Position of a place relative to the mesh's border. CML_AT_BORDER: within a given distance of the border. */
enum cml_border_side { CML_OUTSIDE_BORDER, CML_AT_BORDER, CML_INSIDE_BORDER };

/* Returns on which side of the mesh's border (x, y) lies: at the border if it is within distance d, cm; else
 * outside or inside. */
enum cml_border_side cml_query_border_side(const struct cml_mesh_query *q, double x, double y, double d);

/* Intersects the ray with the outer plane, which may become the best crossing. Sets q->in_doubt close to the
 * border. */
void cml_query_intersect_outer_plane(struct cml_mesh_query *q);

/* True if rounding may have decided which crossing is the best, or that there is none. The caller must then
 * call cml_line_decide. In a union (mesh->unite) also true if another part of the mesh may surround the
 * crossing, or may pass the place where the packet stands. */
bool cml_query_is_doubtful(const struct cml_mesh_query *q);

/* Returns 1 and sets *crossing, with its normals, if the query has found one; else returns 0. p, u: as given
 * to cml_query_begin. */
int cml_query_finish(const struct cml_mesh_query *q, const double p[3], const double u[3],
                     struct cml_mesh_crossing *crossing);
