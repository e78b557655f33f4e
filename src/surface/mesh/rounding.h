/* Bounds of rounding: every length, sine and share of this room that exists only because numbers are rounded.
 * All are called err_, and all are in this table; what is set per mesh or per query is a member of that name.
 *
 * eps is DBL_EPSILON, 2^-52: an operation in double rounds by eps / 2 of its result, a number in float by
 * 2^-24 = 6e-8. D is the diagonal of the mesh's box. Coordinates count from its middle (mesh_body.h), so
 * differences of two of them are at most D. "Fails": tests of tests/unit/surface/mesh that fail when the
 * bound is divided by 100, measured with all of them and cross.clearance; "none" means that the bound follows
 * from its derivation only.
 *
 * Lengths, cm
 *   err_position  How far rounding has put the packet beyond a facet that it has not crossed. From the
 * caller: 4 times the precision of its numbers times |x| + |y| + |z| (kernels/surface_hit.h). err_mesh How
 * far the rounding of a query can put a crossing from where it is. 16 eps D. The way to a crossing is a
 * difference of places, the facet's normal (edges, cross product, length), two scalar products, a quotient,
 * and p + t u: some 16 roundings of eps / 2 D, where the facet is no needle, and twice that. Fails:
 * concave_vertex, grid_walk. err_query     Both: err_position + err_mesh. Fails: mesh_line, mesh_surface,
 * grid_walk. err_line      Between a packet and the facet that it stands on or that its line leaves by. 4
 * err_query: packet, crossing, and both again when the line is moved by err_query to begin with. Fails:
 * mesh_line, mesh_surface, concave_vertex. err_entry     Rounding of the entry point p + t u. eps (t + sum of
 * |p| and |entry|): each coordinate is rounded by eps / 2 in p, in t u and in the sum; twice that, summed up
 * over the axes. Fails: none. err_float     What float can do to a ray and a box inside the mesh's. 1e-6 D:
 * vertex and origin 3e-8 D each (coordinates up to D / 2), direction 6e-8 D, Embree's test of a box some four
 * roundings more, 2.4e-7 D: 3.6e-7 D in all. Fails: all four of mesh_line, mesh_surface, grid_walk,
 * concave_vertex.
 *
 * Areas, cm2
 *   an edge product d . (a x b), a and b from the entry point: 4 eps |a| |b| + err_entry |a - b|, in the sum
 *       norm. Each of its six terms goes through seven roundings (a, b, product, difference, product, two
 * sums): 3.5 eps of the sum of their sizes, which is at most |a| |b|. An entry point that is off by err_entry
 *       moves the product by that times the edge. Fails: none.
 *   err_product   At least that for every edge: a, b and the edge are at most the sum of the box's sides, and
 *       twice that, for an entry point a little before the box. Fails: none.
 *
 * Shares of a triangle
 *   err_weight         A barycentric weight below is that of a place on the edge. 1e-12: rounding of an edge
 *       product is less than that of a triangle's area up to 30 of its sizes away. Fails: none.
 *   err_weight_embree  The same of Embree's weights. 1e-5: 6e-8 at up to 160 sizes. Fails: none.
 *   err_height_embree  By how much of its height a triangle is enlarged for Embree, which in float lets rays
 * pass between neighbours, most easily along edges and at corners. 1e-3: twice 3e-8 D of a vertex is less for
 *       triangles of at least 6e-5 D. Fails: mesh_line.
 *
 * Sines of small angles, at which rounding err across moves a crossing by err / sine along the ray
 *   err_sine_embree  To a facet: below, Embree's order of hits is not believed. 1e-2: float coordinates then
 *       move a crossing by 6e-6 D. Fails: mesh_line.
 *   err_sine_border  To the outer plane: below, Embree's hit may be on the wrong side of the border. 1e-2, as
 *       that. Fails: mesh_line.
 *   err_sine_grid    To a facet: below, a traversal is undecided. 1e-4: above, err_mesh moves a crossing by
 *       3.6e-11 D, less than err_cell in grids of up to 2e4 x 2e4 cells. Fails: none.
 *   err_sine_edge    To an edge: below, it does not tell where a line leaves the facet. 1e-6: err_mesh then
 *       moves the place by 3.6e-9 D. Fails: none.
 *
 * Grids
 *   err_cell  How far, in cells, an edge may lie from where the grid says, and a ray from where it is.
 *       2 deviations of the vertices, and err_cell_least = 1e-6 for the ray. Fails: none.
 *   err_start By how much, in halves of the mesh's width, a traversal begins before a ray's first crossing
 * may lie, and in what distance of it a hit is undecided. 1e-10: err_mesh / err_sine_grid. Fails: none.
 *
 * Factors
 *   err_grazing_factor  On err_position, for crossings behind the packet: across the facet err_position is
 * the bound, along a ray at a small angle to it more is allowed, up to 32 of it. Fails: none.
 *   err_cover_factor    On err_position + err_entry, for the distance from a grid's rim: twice the former.
 *       Fails: none.
 * SPDX-License-Identifier: MIT */
#ifndef CML_ROUNDING_H
#define CML_ROUNDING_H

#include <float.h>

/* err_mesh and err_float over D; an edge product's share of |a| |b| */
static const double err_share_mesh = 16 * DBL_EPSILON, err_share_float = 1e-6;
static const double err_share_product = 4 * DBL_EPSILON;

static const double err_weight = 1e-12, err_weight_embree = 1e-5;
static const float err_height_embree = 1e-3f;
static const double err_sine_embree = 1e-2, err_sine_border = 1e-2, err_sine_grid = 1e-4,
                    err_sine_edge = 1e-6;
static const double err_cell_least = 1e-6, err_start = 1e-10;
static const double err_line_factor = 4, err_grazing_factor = 32, err_cover_factor = 64;

#endif
