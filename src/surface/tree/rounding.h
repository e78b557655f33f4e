/* Bounds of rounding. The table holds every length, sine and share in surface/tree and surface/mesh that
 * exists only because numbers are rounded. All names begin with err_. Bounds that depend on a mesh or a query
 * are members of that name.
 *
 * eps is DBL_EPSILON, 2^-52: an operation in double rounds by eps / 2 of its result, an operation in float by
 * 6e-8. D is the diagonal of the mesh's box. Coordinates count from the box's middle (centred_mesh.h), so
 * that inside the box they are at most D / 2. "Fails" names the tests (in tests/unit/surface/mesh, and
 * cross.bounds) that fail if the bound is made a hundredth; all of them were run. "Fails: none" means that
 * the value rests on its derivation alone.
 *
 * Lengths, cm
 *   err_position: how far rounding has put the packet beyond a facet that it has not crossed. Given by the
 *     caller: 4 times the precision of its numbers times |x| + |y| + |z| (kernels/surface_hit.h).
 *   err_mesh: how far the rounding of a query can move a crossing, 16 eps D. A crossing needs a difference of
 *     places, the facet's normal (edges, cross product, length), two scalar products, a quotient, and p + t
 *     u: some 16 roundings of eps / 2 D, unless the facet is a needle. The bound is twice that. Fails:
 *     concave_vertex, grid_walk.
 *   err_query: err_position + err_mesh. Also the contact distance of a packet. Fails: mesh_line,
 *     mesh_surface, grid_walk.
 *   err_line: distance between a packet and the facet on which it stands, or through which its line leaves: 4
 *     err_query. One err_query each is for the packet, for the crossing, and for the line's beginning, which
 *     is moved ahead by err_query; one is spare. Fails: mesh_line, mesh_surface, concave_vertex.
 *   err_entry: error of the entry point p + t u: eps (t + sum of |p| and |entry|). Each coordinate is rounded
 *     by eps / 2 in p, in t u and in the sum; the bound is twice that, summed over the axes. Fails: none; see
 *     edge product.
 *   err_float: effect of float on a ray and a box inside the mesh's box: 1e-6 D. Vertex and origin are off by
 *     3e-8 D each, the direction by 6e-8 D, and Embree's test of a box adds four roundings, 2.4e-7 D: 3.6e-7
 *     D in all. A closed mesh may be small and far from the origin of coordinates; it adds err_line in float
 *     (fails: closed_mesh). Fails: mesh_line, mesh_surface, grid_walk, concave_vertex.
 *   err_margin: how near a ray may pass a facet's edge, begin or end at its plane, or meet two facets, before
 *     the tree (surface/tree) leaves the case to doubles: err_share_float D + err_query + err_entry. The last
 *     two terms belong to the question what a crossing is. The first term must cover the rounding of floats,
 *     16.8 f D with f = 2^-24:
 *     - Rays begin in the box, |origin| <= D / 2 and t <= D. A ray shorter than half the box's width may also
 *       begin as much above it: |origin| <= D and t <= D / 2.
 *     - Height of the origin over a plane: 7 f D, from the rounded origin and normal, three products, two
 *       sums, offset, difference.
 *     - Sine of the angle between plane and ray: 5 f, from two roundings, product, two sums.
 *     - The quotient t of height and sine is off by (7 + 5 / 2) f D over the computed sine, and by 3 f D for
 *       its own two roundings: 12.5 f D / sine. The place in the plane moves by as much; its coordinates
 *       (origin, product, sum) add 3 f D.
 *     - A weight is a linear function of the place, and an error in it is a distance over a height. Slope and
 *       place in three products, three sums and offset give 4.5 f D. The third weight is computed from the
 *       other two, and the side opposite to it is the longest: 9 f D.
 *     - In all: 12 f D + 12.5 f D / sine across an edge, which is less than err_margin (1 + 1 / sine), and
 *       14.5 f D for the two ends of the path.
 *     - Boxes are enlarged by twice the margin. The second margin is for the slabs, whose two differences and
 *       two products are off by 3.5 f D.
 *   Fails: facet_tree.
 *
 * Areas, cm2, by the sum norm
 *   edge product d . (a x b), with a and b from the entry point: 4 eps |a| |b| + err_entry |a - b|. Each of
 *     its six terms goes through seven roundings (a, b, product, difference, product, two sums). That is 3.5
 *     eps of the sum of the terms' sizes, which is at most |a| |b|. An error of the entry point moves the
 *     product by the error times the edge. Fails: mesh_surface and concave_vertex if this bound and err_entry
 *     are both made a thousandth; either alone covers for the other. cml_facet_crossing bounds its products
 *     in the same way.
 *   err_product: a bound of the edge product for every edge of the mesh, because |a|, |b| and |a - b| are at
 *     most the sum of the box's sides. Doubled for an entry point a little before the box. Fails: none.
 *
 * Shares of a triangle
 *   err_weight: a place with a barycentric weight below this is on the edge: 1e-12. The bound exceeds the
 *     rounding of edge products if the triangle is at most 30 of its sizes from the entry point; further away
 *     the edge product still marks the edge. Fails: none; with 0 mesh_surface, grid_walk.
 *   err_weight_sheet: error of the weights of a sheet's facets, which are kept in float: 1e-4. A facet whose
 *     error is larger has no weights, and is hit only by the exact query. The error has a term for float
 *     (FLT_EPSILON of each derivative, times how far the facet's cells reach) and a term for the ray
 *     (err_mesh / err_sine_grid). Fails: none.
 *
 * Sines of angles to a ray; rounding across a facet moves the crossing along the ray by rounding / sine
 *   err_sine_grid: of the angle to a facet; below it a traversal is undecided: 1e-4. Above it, err_mesh moves
 *     a crossing by at most 3.6e-11 D, less than err_cell in grids of up to 2e4 x 2e4 cells. Fails: none.
 *   err_sine_edge: of the angle to an edge; below it the edge does not tell where a line leaves the facet:
 *     1e-6. Above it, err_mesh moves that place by at most 3.6e-9 D. Fails: concave_vertex.
 *
 * Grids
 *   err_cell: how far rounding can move a ray, in cells: 1e-6, see err_sine_grid. Fails: none.
 *   err_apart: how far rounding can separate facet, cell and ray in all, in cells: 4 err_cell. One err_cell
 *     is for each of the three, and one is spare. Fails: none.
 *   err_start: in half widths of the mesh, how far before the least distance of a crossing a traversal
 *     begins, and how far behind that distance hits are undecided: 1e-10, which is err_mesh / err_sine_grid
 *     in a square mesh. Fails: none.
 *
 * Factors
 *   err_grazing_factor: on err_position, for crossings behind the packet. Across the facet err_position is
 *     the bound. Along a ray at a small angle to the facet up to 32 times that is allowed; beyond, the whole
 *     line decides. Fails: none with 1.
 *   err_cover_factor: on err_position + err_entry, for the distance of a ray from the end of a grid: 64,
 *     twice err_grazing_factor. Fails: none.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <float.h>

/* err_mesh and err_float as shares of D; an edge product's share of |a| |b| */
static const double err_share_mesh = 16 * DBL_EPSILON, err_share_float = 1e-6;
static const double err_share_product = 4 * DBL_EPSILON;

static const double err_weight = 1e-12, err_weight_sheet = 1e-4;
static const double err_sine_grid = 1e-4, err_sine_edge = 1e-6;
static const double err_cell = 1e-6, err_apart = 4e-6, err_start = 1e-10;
static const double err_line_factor = 4, err_grazing_factor = 32, err_cover_factor = 64;
