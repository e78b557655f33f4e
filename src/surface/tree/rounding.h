/* Bounds of rounding: every length, sine and share of surface/tree and surface/mesh that exists only because
 * numbers are rounded. All are called err_, and all are in this table; those that depend on a mesh or a query
 * are members of that name.
 *
 * eps is DBL_EPSILON, 2^-52: an operation in double rounds by eps / 2 of its result, one in float by 6e-8.
 * D is the diagonal of the mesh's box. Coordinates count from its middle (centred_mesh.h), so none inside the
 * box is more than D / 2. "Fails": the tests of tests/unit/surface/mesh, and cross.bounds, that fail
 * when the bound is made a hundredth of what it is; all of them were run. "None" means that the value
 * stands on its derivation alone.
 *
 * Lengths, cm
 *   err_position: How far rounding has put the packet beyond a facet that it has not crossed. From the
 *     caller: 4 times the precision of its numbers times |x| + |y| + |z| (kernels/surface_hit.h).
 *   err_mesh: How far the rounding of a query can put a crossing from where it is: 16 eps D. The way to a
 *     crossing is a difference of places, the facet's normal (edges, cross product, length), two scalar
 *     products, a quotient, and p + t u: some 16 roundings of eps / 2 D, unless the facet is a needle, and
 *     twice that. Fails: concave_vertex, grid_walk.
 *   err_query: err_position + err_mesh. The contact distance of a packet too. Fails: mesh_line,
 *     mesh_surface, grid_walk.
 *   err_line: Between a packet and the facet that it stands on, or that its line leaves by: 4 err_query,
 *     for the packet, the crossing, and the line's beginning, which is moved ahead by err_query; one is to
 *     spare. Fails: mesh_line, mesh_surface, concave_vertex.
 *   err_entry: Of the entry point p + t u: eps (t + sum of |p| and |entry|). Each coordinate is rounded by
 *     eps / 2 in p, in t u and in the sum; twice that, summed over the axes. Fails: none; see edge product.
 *   err_float: What float can do to a ray and a box inside the mesh's: 1e-6 D. Vertex and origin 3e-8 D
 *     each, direction 6e-8 D, Embree's test of a box four roundings more, 2.4e-7 D: 3.6e-7 D in all. Of a
 *     closed mesh, which may be small and far from where coordinates count from, err_line in float as well
 *     (fails: closed_mesh).
 *     Fails: mesh_line, mesh_surface, grid_walk, concave_vertex.
 *   err_margin: How near a ray may pass a facet's edge, begin or end at its plane, or meet two facets, before
 *     the tree (surface/tree) leaves that to doubles: err_share_float D + err_query + err_entry. The last two
 *     are for what counts as a crossing at all; the first, 16.8 f D with f = 2^-24, for floats:
 *     Rays begin in the box, |origin| <= D / 2 and t <= D, or, shorter than half its width, as much above it,
 *     |origin| <= D and t <= D / 2. The height of the origin over a plane: origin and normal are
 *     rounded, three products and two sums, offset, difference: 7 f D. The sine of the angle between plane
 *     and ray: two roundings, product, two sums, 5 f. So t, their quotient, is off by (7 + 5 / 2) f D over
 *     the sine that was computed, and by 3 f D more by its own two roundings: 12.5 f D / sine. That moves the
 *     place in the plane by as much; its coordinates (origin, product, sum) by 3 f D. A weight is a linear
 *     function of it, and its error a distance over a height: slope and place in three products, three sums,
 *     offset: 4.5 f D; of the third, the sum of both, where the side opposite to it is the longest, 9 f D. In
 *     all 12 f D + 12.5 f D / sine across an edge, less than err_margin (1 + 1 / sine), and 14.5 f D for the
 *     two ends of the path. Boxes are larger by twice the margin, once more for the slabs, whose two
 *     differences and two products are off by 3.5 f D. Fails: facet_tree.
 *
 * Areas, cm2, by the sum norm
 *   edge product d . (a x b), a and b from the entry point: 4 eps |a| |b| + err_entry |a - b|. Each of its
 *     six terms goes through seven roundings (a, b, product, difference, product, two sums), so 3.5 eps of
 *     the sum of their sizes, which is at most |a| |b|. An entry point that is off moves the product by
 *     that times the edge. Fails: mesh_surface and concave_vertex when this and err_entry are both made a
 *     thousandth; either alone covers for the other. cml_facet_crossing bounds its products alike.
 *   err_product: At least that for every edge of the mesh, for |a|, |b| and |a - b| are at most the sum of
 *     the box's sides; twice that, for an entry point that is put a little before the box. Fails: none.
 *
 * Shares of a triangle
 *   err_weight: A barycentric weight below is that of a place on the edge: 1e-12. Above, it is more than
 *     the rounding of edge products as long as the triangle is at most 30 of its sizes from the entry
 *     point; further away the edge product still marks the edge. Fails: none; with 0 mesh_surface, grid_walk.
 *   err_weight_sheet: Of the weights of a sheet's facets, which are kept in float: 1e-4. A facet for which
 *     float (FLT_EPSILON of each derivative, times how far its cells reach) and err_mesh / err_sine_grid, for
 *     the ray, make more than that has none, and is never hit without the exact query. Fails: none.
 *
 * Sines of angles to a ray; rounding across a facet moves the crossing along the ray by that / sine
 *   err_sine_grid: To a facet: below, a traversal is undecided: 1e-4. Above, err_mesh moves a crossing by
 *     at most 3.6e-11 D, less than err_cell in grids of up to 2e4 x 2e4 cells. Fails: none.
 *   err_sine_edge: To an edge: below, it does not tell where a line leaves the facet: 1e-6. Above,
 *     err_mesh moves that place by at most 3.6e-9 D. Fails: concave_vertex.
 *
 * Grids
 *   err_cell: How far, in cells, a ray may lie from where it is: 1e-6, see err_sine_grid. Fails: none.
 *   err_apart: In cells, how far rounding may put facet, cell and ray apart, altogether: 4 err_cell, for the
 *     three of them, and one to spare. Fails: none.
 *   err_start: In halves of the mesh's width, how far before the least distance of a crossing a traversal
 *     begins, and how far behind it hits are undecided: 1e-10, err_mesh / err_sine_grid in a square mesh.
 *     Fails: none.
 *
 * Factors
 *   err_grazing_factor: On err_position, for crossings behind the packet: across the facet err_position is
 *     the bound; along a ray at a small angle to it more is allowed, but no more than 32 times that: beyond,
 *     the whole line decides. Fails: none with 1.
 *   err_cover_factor: On err_position + err_entry, for the distance of a ray from the end of a grid: 64,
 *     twice the former. Fails: none.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <float.h>

/* err_mesh and err_float over D; an edge product's share of |a| |b| */
static const double err_share_mesh = 16 * DBL_EPSILON, err_share_float = 1e-6;
static const double err_share_product = 4 * DBL_EPSILON;

static const double err_weight = 1e-12, err_weight_sheet = 1e-4;
static const double err_sine_grid = 1e-4, err_sine_edge = 1e-6;
static const double err_cell = 1e-6, err_apart = 4e-6, err_start = 1e-10;
static const double err_line_factor = 4, err_grazing_factor = 32, err_cover_factor = 64;
