/* Triangle meshes that serve as one boundary: data, orientation, border and statistics. Knows no files and no
 * rays.
 *
 * A boundary mesh is one orientable sheet (2-manifold) with exactly one border loop, which lies on one
 * horizontal plane. Outside the border the boundary continues as that plane to infinity. The sheet need not
 * be a height function:
 *
 *             _
 *            / /    /\/\           side view
 *     ______/ /____/    \______
 *           ^ border    ^            z_border: depth of the outer plane
 *
 * Coordinates are in the boundary's frame, in cm: x, y of the scene, z down, z = 0 at the boundary's nominal
 * depth.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The normal that the physics uses at a hit. On which side of the mesh a packet is, the facet alone
 * decides. */
enum cml_normals {
    CML_NORMALS_FACET,
    CML_NORMALS_VERTEX,   /* vertex normals, weighted by angle and interpolated */
    CML_NORMALS_ANALYTIC, /* normal of the cone that a tessellated heightfield's triangle approximates */
};

/* A mesh. Triangles run counter-clockwise seen from above: cross(b-a, c-a) points up (z < 0) wherever the
 * sheet is a height function; see cml_mesh_prepare. */
struct cml_mesh {
    size_t num_vertices, num_triangles;
    double (*vertex)[3];     /* [num_vertices] positions, cm */
    uint32_t (*triangle)[3]; /* [num_triangles] vertices of each, counter-clockwise */
    uint32_t *border; /* [num_border] vertices of the border loop, from the lowest index on, in the winding of
                         the triangles: the loop's signed area in (x, y) is negative */
    size_t num_border;
    double z_border;           /* depth of the border's plane in the boundary's frame, cm */
    double lower[3], upper[3]; /* bounding box, cm */
    enum cml_normals normals;
    bool closed; /* set before cml_mesh_prepare: the mesh is a body without a border, not a sheet */
    bool unite;  /* set before cml_mesh_prepare, for a body whose inside is the union of the insides of its
                    parts; cleared if there is only one part */
    size_t num_parts; /* number of parts of a body, which are closed surfaces without a common corner; 0 for a
                         sheet */
    uint32_t *part;   /* [num_triangles] part to which each triangle belongs; NULL for a sheet */
    uint32_t *part_start; /* [num_parts] first triangle of each part, rising; NULL for a sheet */
    double weld;          /* vertices nearer to each other than this are joined, cm; 0: only equal ones */
    double skirt; /* width of the skirt that cml_mesh_prepare adds to a border that is not level, cm; 0: such
                     a border is refused */
    double (*vertex_normal)[3]; /* [num_vertices] unit, up, weighted by angle; at the border the outer plane
                                   counts with its own angle; present after cml_mesh_prepare */
    double *slope;              /* [num_triangles] dz/dr of the cone for CML_NORMALS_ANALYTIC, else NULL */
};

/* Frees a mesh's arrays and zeroes it. */
void cml_mesh_clear(struct cml_mesh *mesh);

/* Allocates memory for the given numbers of vertices and triangles. The mesh then has no triangles yet.
 * Clears the mesh if memory runs out. what: name of the mesh for the message. */
CML_NODISCARD cml_status cml_mesh_allocate(struct cml_mesh *mesh, size_t vertices, size_t triangles,
                                           const char *what, struct cml_error *err);

/* Adds a triangle, for which cml_mesh_allocate has made room. */
void cml_mesh_add_triangle(struct cml_mesh *mesh, size_t a, size_t b, size_t c);

/* Copies a mesh with all of its arrays. */
CML_NODISCARD cml_status cml_mesh_copy(const struct cml_mesh *from, struct cml_mesh *to,
                                       struct cml_error *err);

/* Line numbers that a loader has noted, so that messages can point into its file. */
struct cml_mesh_source {
    const char *path;
    const int *vertex_line;   /* [num_vertices] line of each vertex, or NULL */
    const int *triangle_line; /* [num_triangles] line of each triangle, or NULL */
};

/* The changes that cml_mesh_prepare made; printed by `check`. */
struct cml_mesh_notes {
    size_t welded;        /* vertices joined with another vertex of the same coordinates */
    size_t joined;        /* vertices joined with another vertex of other coordinates (mesh->weld) */
    double join_distance; /* largest distance by which such a vertex moved, cm */
    size_t degenerate;    /* triangles of zero area that were dropped */
    size_t unused;        /* dropped vertices that no triangle uses */
    size_t flipped;       /* triangles whose winding was reversed */
    size_t cavities;      /* parts of a body that are cavities */
    size_t bent;     /* polygons whose corners do not lie in a plane; their reader cuts them into triangles */
    double bend;     /* largest distance of such a corner from its polygon's mean plane, cm */
    double levelled; /* range of the border's depths before it was levelled, cm, if larger than rounding; else
                        0 */
    size_t skirt;    /* triangles of the skirt, which are the last triangles of the mesh */
    double skirt_rise; /* largest height difference between the old border and the skirt's outer edge, cm */
};

/* Makes a boundary mesh from loose vertices and triangles.
 * - Joins vertices with equal coordinates, and vertices nearer than mesh->weld to the first of them; drops
 * triangles of zero area and unused vertices.
 * - Refuses anything but one connected, orientable 2-manifold sheet with one border loop.
 * - Levels the border: if its depths differ by at most 1e-6 of the largest side of the mesh's box, its
 * vertices move to their mean depth, z_border. For larger differences, mesh->skirt > 0 adds a skirt from the
 * border to its mean height (mesh_skirt.c); without a skirt the mesh is refused.
 * - Orients all triangles so that "up" is the side of the medium above, which the outer plane at the border
 * defines.
 * - Computes box, border and vertex normals.
 * Vertices and triangles keep their order, so a prepared mesh passes unchanged; a coordinate of -0.0 becomes
 * 0.0. Crossings of the sheet with itself or with its outer plane are not searched for. `source` and `notes`
 * may be NULL. Errors (CML_E_INPUT) name path, line and place: x, y and height (-z) in cm. After an error
 * *mesh can only be cleared. */
CML_NODISCARD cml_status cml_mesh_prepare(struct cml_mesh *mesh, const struct cml_mesh_source *source,
                                          struct cml_mesh_notes *notes, struct cml_error *err);

/* A closed body (mesh->closed) is prepared by cml_mesh_prepare, too. A body with a border edge is refused.
 * Triangles are turned so that normals point outwards; num_border is 0 and z_border the body's smallest
 * depth. A body may have several parts: a part inside another is a cavity, whose normals point into it; a
 * part inside a cavity is solid again, and so on. With mesh->unite, each part's normals point out of the
 * part. Parts that cross each other are not searched for; a part without volume is refused. */

/* True if every vertex lies at the same depth: the boundary is then the plane at z = *z. */
bool cml_mesh_is_flat(const struct cml_mesh *mesh, double *z);

/* Statistics of heights and edges, for `check`. */
struct cml_mesh_summary {
    double z_mean, z_rms, peak_to_valley; /* cm, weighted by projected area; z_rms about the mean */
    double slope_rms, slope_max;  /* root mean square and maximum of the slope, cm per cm; infinite if there
                                     are vertical walls */
    double edge_median, edge_min; /* cm; NaN if memory runs out */
};

/* Computes the statistics of a prepared mesh. */
void cml_mesh_summarise(const struct cml_mesh *mesh, struct cml_mesh_summary *summary);
